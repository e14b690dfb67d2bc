// A recorded session as a value: what session.toml says, where its files lie. No OpenNI2, no pixels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

struct SessionStream {
    std::string sensor;           ///< name in calibration.toml
    std::filesystem::path file;  ///< absolute: the .oni file, or a folder of PNG for video
    int64_t start_us = 0;         ///< added to the stamps of the file
    int64_t frames = 0;
    std::string checksum;         ///< "xxh3-64:<16 hex digits>" of the file's bytes
};

struct Session {
    std::filesystem::path folder;
    std::string name;
    std::string created;  ///< RFC 3339 UTC
    std::vector<SessionStream> streams;  ///< in the order of calibration.toml
    SensorRig rig;
    std::optional<std::filesystem::path> settings, part, truth, expected;  ///< where present
    std::vector<std::string> warnings;
};

/// Opens a session folder: session.toml, calibration.toml, each stream present and its checksum right
/// (`verify` = false skips only the checksums). Refuses with one sentence naming file and key.
Result<Session> open_session(const std::filesystem::path& folder, bool verify = true);

/// The empty cell as one depth image a depth sensor, in the rig's order; nullopt where the session holds none.
Result<std::vector<std::optional<DepthImage>>> read_background(const Session& session);

}  // namespace deixis
