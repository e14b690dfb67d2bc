// A small file as one string: read with a limit, written all or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "tracking/geometry/result.h"

namespace deixis {

/// The bytes of a regular file of at most `limit` bytes; refuses anything else, naming the file.
Result<std::string> read_whole_file(const std::filesystem::path& path, size_t limit);

/// Writes `bytes` beside `path`, waits for the disk and renames it into place: after any failure `path` is as
/// before.
Result<void> write_whole_file(const std::filesystem::path& path, std::string_view bytes);

/// Waits until the entries of `folder` (created, renamed, removed files) are on the disk.
Result<void> sync_folder(const std::filesystem::path& folder);

}  // namespace deixis
