// A part as the station knows it: type, serial, model file, zones. Read from part.toml.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

struct Zone {
    std::string name;
    Box box;  ///< part frame [m]
};

/// part.toml as it stands in the file.
struct PartFile {
    std::string type;
    std::string serial;
    std::filesystem::path model;  ///< absolute, or relative to the working directory after reading
    double metres_per_unit = 0.001;
    std::vector<Zone> zones;
    std::vector<std::string> warnings;  ///< unknown keys, one sentence each
};

/// Reads and checks `path`; refuses missing, empty, mistyped or out-of-range keys, naming file and key.
Result<PartFile> read_part_file(const std::filesystem::path& path);

/// The name of the first zone that holds the point (part frame [m]); empty when none does.
std::string zone_of(const std::vector<Zone>& zones, const Eigen::Vector3d& position_part);

}  // namespace deixis
