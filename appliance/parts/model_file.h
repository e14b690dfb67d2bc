// A part's model file read within the calling process.
#pragma once

#include <filesystem>

#include "tracking/geometry/result.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

constexpr size_t most_triangles = 8'000'000;
constexpr size_t most_vertices = 3 * most_triangles;

/// What `load_mesh` (model_reader.h) does, here and now. A damaged file can crash the libraries that read it
/// or keep them for ever: a program that has to go on uses `load_mesh`; this is for the child behind it,
/// tools and tests.
Result<SurfaceMesh> read_model_file(const std::filesystem::path& model, double metres_per_unit);

/// Refuses a mesh without triangle, with too many, with an index beyond its vertices, a NaN, or not 1 cm to
/// 20 m long, naming `model`.
Result<SurfaceMesh> checked_mesh(SurfaceMesh mesh, const std::filesystem::path& model);

}  // namespace deixis
