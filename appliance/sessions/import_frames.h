// A frames folder (PNG images from anywhere, formats "A frames folder") made into a session folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "appliance/sessions/session_writer.h"
#include "tracking/geometry/result.h"

namespace deixis {

struct ImportReport {
    std::vector<int64_t> frames;        ///< a sensor, in the order of calibration.toml
    std::vector<std::string> warnings;  ///< unknown keys and files that were left out, one sentence each
};

/// Checks everything, then writes the session `out` (must not exist). Nothing stands at `out` after a
/// refusal. `origin.name` empty: the folder's name.
Result<ImportReport> import_frames(const std::filesystem::path& folder, const std::filesystem::path& out,
                                   SessionOrigin origin);

}  // namespace deixis
