// Signed distances and surface nets.
#include "appliance/simulation/implicit_solid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace deixis {

float distance_to(const SolidPrimitive& s, const Eigen::Vector3f& p) {
    if (s.ellipsoid) {
        const Eigen::Vector3f q = p - s.a;
        const float k0 = q.cwiseQuotient(s.b).norm();
        const float k1 = q.cwiseQuotient(s.b.cwiseProduct(s.b)).norm();
        return k1 > 1e-6F ? k0 * (k0 - 1) / k1 : -s.b.minCoeff();
    }
    const Eigen::Vector3f axis = s.b - s.a;
    const float t = std::clamp((p - s.a).dot(axis) / axis.squaredNorm(), 0.0F, 1.0F);
    return (p - s.a - t * axis).norm() - (s.ra + t * (s.rb - s.ra));
}

float distance_to_union(const std::vector<SolidPrimitive>& primitives, const Eigen::Vector3f& p,
                        float fillet) {
    float d = 1e9F;
    for (const SolidPrimitive& s : primitives) {
        const float e = distance_to(s, p);
        const float h = std::max(fillet - std::abs(d - e), 0.0F) / fillet;
        d = std::min(d, e) - h * h * fillet * 0.25F;
    }
    return d;
}

namespace {

struct Grid {
    Eigen::Vector3f origin;
    float cell = 0;
    std::array<int, 3> n{};  ///< samples along x, y, z
    std::vector<float> d;

    size_t index(int x, int y, int z) const { return (static_cast<size_t>(z) * n[1] + y) * n[0] + x; }
};

Grid sample(const std::vector<SolidPrimitive>& primitives, float fillet, float cell) {
    Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F), high = -low;
    for (const SolidPrimitive& s : primitives) {
        const Eigen::Vector3f ra = s.ellipsoid ? s.b : Eigen::Vector3f::Constant(s.ra);
        low = low.cwiseMin(s.a - ra);
        high = high.cwiseMax(s.a + ra);
        if (s.ellipsoid) continue;
        low = low.cwiseMin(s.b - Eigen::Vector3f::Constant(s.rb));
        high = high.cwiseMax(s.b + Eigen::Vector3f::Constant(s.rb));
    }
    Grid g;
    g.cell = cell;
    g.origin = low - Eigen::Vector3f::Constant(2 * cell + 0.5F * fillet);
    for (int i = 0; i < 3; ++i) g.n[i] = static_cast<int>((high[i] - g.origin[i] + 0.5F * fillet) / cell) + 3;
    g.d.resize(static_cast<size_t>(g.n[0]) * g.n[1] * g.n[2]);
    for (int z = 0; z < g.n[2]; ++z)
        for (int y = 0; y < g.n[1]; ++y)
            for (int x = 0; x < g.n[0]; ++x)
                g.d[g.index(x, y, z)] = distance_to_union(
                    primitives,
                    g.origin + cell * Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y),
                                                      static_cast<float>(z)),
                    fillet);
    return g;
}

/// Mean of the crossings on the twelve edges of the cube at (x, y, z); false when the surface misses it.
bool net_vertex(const Grid& g, int x, int y, int z, Eigen::Vector3f& vertex) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int crossings = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int corner = 0; corner < 4; ++corner) {
            std::array<int, 3> a{x, y, z};
            a[(axis + 1) % 3] += corner & 1;
            a[(axis + 2) % 3] += corner >> 1;
            std::array<int, 3> b = a;
            b[axis] += 1;
            const float da = g.d[g.index(a[0], a[1], a[2])], db = g.d[g.index(b[0], b[1], b[2])];
            if ((da < 0) == (db < 0)) continue;
            Eigen::Vector3f p(static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2]));
            p[axis] += da / (da - db);
            sum += p;
            ++crossings;
        }
    if (crossings == 0) return false;
    vertex = g.origin + g.cell * sum / static_cast<float>(crossings);
    return true;
}

}  // namespace

SurfaceMesh mesh_of_union(const std::vector<SolidPrimitive>& primitives, float fillet, float cell) {
    const Grid g = sample(primitives, fillet, cell);
    SurfaceMesh mesh;
    std::vector<uint32_t> vertex_of(g.d.size(), 0);
    for (int z = 0; z + 1 < g.n[2]; ++z)
        for (int y = 0; y + 1 < g.n[1]; ++y)
            for (int x = 0; x + 1 < g.n[0]; ++x) {
                Eigen::Vector3f vertex;
                if (!net_vertex(g, x, y, z, vertex)) continue;
                vertex_of[g.index(x, y, z)] = static_cast<uint32_t>(mesh.vertices.size());
                mesh.vertices.push_back(vertex);
            }
    // Every grid edge that crosses the surface joins the vertices of the four cubes around it.
    for (int z = 1; z + 1 < g.n[2]; ++z)
        for (int y = 1; y + 1 < g.n[1]; ++y)
            for (int x = 1; x + 1 < g.n[0]; ++x)
                for (int axis = 0; axis < 3; ++axis) {
                    std::array<int, 3> b{x, y, z};
                    b[axis] += 1;
                    const bool inside = g.d[g.index(x, y, z)] < 0;
                    if (inside == (g.d[g.index(b[0], b[1], b[2])] < 0)) continue;
                    std::array<uint32_t, 4> ring{};
                    for (int corner = 0; corner < 4; ++corner) {
                        std::array<int, 3> c{x, y, z};
                        c[(axis + 1) % 3] -= (corner == 1 || corner == 2) ? 1 : 0;
                        c[(axis + 2) % 3] -= corner >= 2 ? 1 : 0;
                        ring[corner] = vertex_of[g.index(c[0], c[1], c[2])];
                    }
                    if (!inside) std::swap(ring[1], ring[3]);
                    mesh.triangles.push_back({ring[0], ring[1], ring[2]});
                    mesh.triangles.push_back({ring[0], ring[2], ring[3]});
                }
    return mesh;
}

}  // namespace deixis
