// Measures of a triangle mesh.
#include "tracking/geometry/surface_mesh.h"

#include <Eigen/Geometry>
#include <cassert>

namespace deixis {

MeshBounds bounds_of(const SurfaceMesh& mesh) {
    assert(!mesh.vertices.empty());
    MeshBounds b{mesh.vertices[0], mesh.vertices[0]};
    for (const auto& v : mesh.vertices) {
        b.min = b.min.cwiseMin(v);
        b.max = b.max.cwiseMax(v);
    }
    return b;
}

Eigen::Vector3f triangle_normal(const SurfaceMesh& mesh, size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3f n =
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    const float length = n.norm();
    return length > 0 ? Eigen::Vector3f(n / length) : Eigen::Vector3f::Zero();
}

void append(SurfaceMesh& mesh, const SurfaceMesh& other) {
    const auto shift = static_cast<uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    mesh.triangles.reserve(mesh.triangles.size() + other.triangles.size());
    for (const auto& t : other.triangles)
        mesh.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
}

}  // namespace deixis
