// All that a maintainer may set, with its defaults: settings.toml, section by section.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "appliance/parts/model_reader.h"
#include "appliance/plc/plc_link.h"
#include "appliance/records/mark_recorder.h"
#include "appliance/station/perception.h"
#include "appliance/station/settings_table.h"
#include "tracking/part/reference_model.h"

namespace deixis {

/// [station]: where a live station finds its files. Relative paths are relative to the settings file.
struct StationFiles {
    std::string calibration;  ///< calibration.toml of the cell
    std::string part;         ///< part.toml of the part type in production
    std::string background;   ///< folder with <sensor>.png of the empty cell
    std::string database = "deixis.db";
    std::string driver_folder;  ///< private OpenNI2 folder; empty: the system's
    InvalidSettings validate() const;
};

/// [screen], handed on to the server by the command.
struct ScreenSettings {
    bool enabled = true;
    std::string host = "127.0.0.1";
    int port = 8765;       ///< 0: any free one
    std::string web_root;  ///< empty: the one that was installed beside the program
    InvalidSettings validate() const;
};

/// [sensors]: see FrameSourceParams.
struct SensorSettings {
    int stall_limit_ms = 1000;
    int pair_patience_ms = 40;
    int restart_delay_ms = 500;
    InvalidSettings validate() const;
};

struct Settings {
    StationFiles station;
    SensorSettings sensors;
    PerceptionParams perception;
    ModelReaderParams model;
    ReferenceModelParams reference;
    LedgerParams ledger;
    MarkRecorderParams recorder;
    PlcParams plc;
    ScreenSettings screen;
};

/// The fields of `settings` by section and key; `settings` must outlive the table.
SettingsTable settings_table(Settings& settings);

struct SettingsFile {
    Settings settings;
    std::vector<std::string> warnings;  ///< unknown keys, one sentence each
};

/// Program defaults overwritten by `path`; refuses as `apply_settings` does, and files that cannot be read or
/// are larger than 1 MB.
Result<SettingsFile> read_settings(const std::filesystem::path& path);

/// The same for text; `name` stands in the sentences.
Result<SettingsFile> parse_settings(std::string_view text, const std::string& name);

}  // namespace deixis
