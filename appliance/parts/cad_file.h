// STEP and IGES files as triangles (Open CASCADE).
#pragma once

#include <filesystem>

#include "tracking/geometry/result.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

/// Reads every shape of a STEP (`iges` false) or IGES file; vertices in metres by the unit that the file
/// itself states. Chord error 0.03 % of the part's diagonal. Refuses what cannot be read or has no face,
/// naming the file.
Result<SurfaceMesh> read_cad_file(const std::filesystem::path& file, bool iges);

}  // namespace deixis
