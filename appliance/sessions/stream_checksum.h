// The checksum of a stream's file or folder: "xxh3-64:<16 hex digits>".
#pragma once

#include <filesystem>
#include <string>

#include "tracking/geometry/result.h"

namespace deixis {

/// Of a file's bytes; of a folder: of its timestamps.csv and then of its PNG files in the order of their
/// names, as if they were one file.
Result<std::string> stream_checksum(const std::filesystem::path& file_or_folder);

}  // namespace deixis
