// A recorded session as a value: what session.toml says, where its files lie. No OpenNI2, no pixels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "appliance/sessions/stream_checksum.h"
#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

struct SessionStream {
    std::string sensor;          ///< name in calibration.toml
    std::filesystem::path file;  ///< absolute: the .oni file, or a folder of PNG for video
    int64_t start_us = 0;        ///< added to the stamps of the file
    int64_t frames = 0;
    std::string checksum;  ///< "xxh3-64:<16 hex digits>", see `stream_checksum`
    std::optional<std::filesystem::path>
        host_times;  ///< CSV with the host's arrival times, where they were known
};

struct Session {
    std::filesystem::path folder;
    std::string name;
    std::string created;                 ///< RFC 3339 UTC
    std::vector<SessionStream> streams;  ///< in the order of calibration.toml
    SensorRig rig;
    std::optional<std::filesystem::path> settings, part, truth, expected;  ///< where present
    std::vector<std::string> warnings;
};

/// Opens a session folder: session.toml, calibration.toml, each stream present and its checksum right
/// (`verify` = false skips only the checksums), each recording's head in accord with session.toml and
/// calibration.toml. Refuses with one sentence naming file and key; unknown keys are warnings.
Result<Session> open_session(const std::filesystem::path& folder, bool verify = true);

/// session.toml alone: name, created, streams with `file` relative as it stands there, tools unchecked;
/// `name` of the file stands in the sentences.
Result<Session> parse_session(std::string_view toml, const std::string& name);

/// The frames of a video stream: the PNG files in order, stamps as in the file (add `start_us`).
struct VideoStream {
    std::vector<std::filesystem::path> files;
    std::vector<int64_t> timestamp_us;
};
Result<VideoStream> open_video_stream(const SessionStream& stream);

/// The host's arrival time of each frame of a stream; empty where they were not known.
Result<std::vector<int64_t>> read_host_times(const SessionStream& stream);

/// The empty cell as one depth image a depth sensor, in the rig's order; nullopt where the session holds
/// none.
Result<std::vector<std::optional<DepthImage>>> read_background(const Session& session);

}  // namespace deixis
