// A file that is there whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

#include "tracking/geometry/result.h"

namespace deixis {

/// Writes `text` under a temporary name in the same folder, syncs it, then renames it to `path`; an older
/// file of that name stays until the rename. Refuses, with one sentence and nothing left behind, a folder
/// that is missing or may not be written, a full disk, and a `path` that is a folder.
Result<void> write_export_file(const std::filesystem::path& path, std::string_view text);

}  // namespace deixis
