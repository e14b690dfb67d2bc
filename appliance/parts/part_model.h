// A part as the station knows it: type, serial, outer skin in metres, zones. Read from part.toml and its CAD
// file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/geometry/surface_mesh.h"

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

/// Loads a STEP, IGES, STL, OBJ or PLY file (by extension, any case) as triangles in metres.
/// Refuses what does not open, holds no triangle or a NaN, or is not 1 cm to 20 m long, naming file and
/// reason.
Result<SurfaceMesh> load_mesh(const std::filesystem::path& model, double metres_per_unit);

/// The name of the first zone that holds the point (part frame [m]); empty when none does.
std::string zone_of(const std::vector<Zone>& zones, const Eigen::Vector3d& position_part);

}  // namespace deixis
