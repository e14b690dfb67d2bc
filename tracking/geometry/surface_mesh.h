// Triangle mesh as a value, with the few measures of it that stages need.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace deixis {

struct SurfaceMesh {
    std::vector<Eigen::Vector3f> vertices;           ///< [m]
    std::vector<std::array<uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
};

struct MeshBounds {
    Eigen::Vector3f min, max;
};

/// Bounds of a mesh with at least one vertex.
MeshBounds bounds_of(const SurfaceMesh& mesh);

/// Unit normal of triangle `t`; zero for a degenerate one.
Eigen::Vector3f triangle_normal(const SurfaceMesh& mesh, size_t t);

/// Adds `other`'s triangles to `mesh`, indices shifted.
void append(SurfaceMesh& mesh, const SurfaceMesh& other);

}  // namespace deixis
