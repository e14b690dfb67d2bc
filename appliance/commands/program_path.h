// Where this program lies, for its children and for the files installed beside it.
#pragma once

#include <filesystem>

namespace deixis {

/// Absolute path of the running executable.
inline std::filesystem::path program_path() {
    return std::filesystem::read_symlink("/proc/self/exe");
}

}  // namespace deixis
