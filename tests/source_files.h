// The files of the source tree, as git knows them, for the tests that read the sources themselves.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace deixis {

/// Environment DEIXIS_SOURCE, else the working directory.
std::filesystem::path source_root();

/// Every file of ours below the root, relative to it, sorted: what git tracks or would track.
std::vector<std::string> source_files();

/// Whether `path` ends in one of `endings`, e.g. {".h", ".cpp"}.
bool ends_in(const std::string& path, const std::vector<std::string>& endings);

/// The lines of a file below the root.
std::vector<std::string> lines_of(const std::string& path);

}  // namespace deixis
