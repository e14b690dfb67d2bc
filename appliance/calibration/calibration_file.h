// calibration.toml, read and written.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

struct CalibrationFile {
    SensorRig rig;
    std::vector<std::string> warnings;  ///< unknown keys, one sentence each
};

/// Reads and checks `path` (format "deixis-calibration/1"); refuses with one sentence naming file, key and
/// what was expected: unknown format, no sensor, duplicate or unusable names, sizes, focal lengths, a
/// rotation that is not orthonormal to 1e-4 or is a reflection, NaN, an empty cell, a zero axis.
Result<CalibrationFile> read_calibration(const std::filesystem::path& path);

/// The same for text in memory; `name` stands in the sentences.
Result<CalibrationFile> parse_calibration(std::string_view text, const std::string& name);

/// The file that `write_calibration` writes.
std::string calibration_text(const SensorRig& rig);

/// Writes `rig` so that `read_calibration` gives the same values back to the last bit; refuses what could
/// not be read back.
Result<void> write_calibration(const SensorRig& rig, const std::filesystem::path& path);

}  // namespace deixis
