// Where the data brought from elsewhere lies.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace deixis {

/// DEIXIS_DATA, else ../shared/data beside the source root.
inline std::filesystem::path data_folder() {
    if (const char* named = std::getenv("DEIXIS_DATA"); named != nullptr) return named;
    const char* source = std::getenv("DEIXIS_SOURCE");
    return std::filesystem::path(source != nullptr ? source : ".") / "../shared/data";
}

}  // namespace deixis
