// A frames folder (PNG images from anywhere, formats "A frames folder") made into a session folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "appliance/sessions/session_writer.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// timestamps.csv: one entry a frame.
struct FrameStamps {
    std::vector<int64_t> timestamp_us;  ///< strictly rising
    std::vector<int64_t> host_us;       ///< empty when the file has no such column
};

/// Header `frame,timestamp_us` or `frame,timestamp_us,host_us`, frames from 0 without gaps. A byte order
/// mark, CRLF, blanks around fields and empty last lines pass; everything else is refused, naming `name` and
/// line.
Result<FrameStamps> parse_timestamps(std::string_view text, const std::string& name);
Result<FrameStamps> read_timestamps(const std::filesystem::path& path);

struct ImportReport {
    std::vector<int64_t> frames;        ///< a sensor, in the order of calibration.toml
    std::vector<std::string> warnings;  ///< unknown keys and files that were left out, one sentence each
};

/// Checks everything, then writes the session `out` (must not exist). Nothing stands at `out` after a
/// refusal. `origin.name` empty: the folder's name.
Result<ImportReport> import_frames(const std::filesystem::path& folder, const std::filesystem::path& out,
                                   SessionOrigin origin);

}  // namespace deixis
