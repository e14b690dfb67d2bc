// Floor, clutter and trolley out of boxes and cylinders.
#include "appliance/simulation/cell_scenery.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "appliance/simulation/counter_random.h"

namespace deixis {

SurfaceMesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                     const RigidTransform& world_from_box) {
    SurfaceMesh mesh;
    for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3d corner((i & 1) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
                                     (i & 4) != 0 ? high.z() : low.z());
        mesh.vertices.emplace_back((world_from_box * corner).cast<float>());
    }
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

SurfaceMesh cylinder_mesh(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, int sides) {
    const Eigen::Vector3d axis = (to - from).normalized();
    const Eigen::Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
    SurfaceMesh mesh;
    mesh.vertices = {from.cast<float>(), to.cast<float>()};
    for (int i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * i / sides;
        const Eigen::Vector3d rim = radius * (std::cos(angle) * u + std::sin(angle) * v);
        mesh.vertices.emplace_back((from + rim).cast<float>());
        mesh.vertices.emplace_back((to + rim).cast<float>());
    }
    for (int i = 0; i < sides; ++i) {
        const auto a = static_cast<uint32_t>(2 + 2 * i), b = static_cast<uint32_t>(2 + 2 * ((i + 1) % sides));
        mesh.triangles.push_back({0, b, a});
        mesh.triangles.push_back({1, a + 1, b + 1});
        mesh.triangles.push_back({a, b, b + 1});
        mesh.triangles.push_back({a, b + 1, a + 1});
    }
    return mesh;
}

namespace {

void add_shelf(SurfaceMesh& mesh, const Eigen::Vector2d& corner, double width, double depth, double height,
               DrawSequence& draw) {
    const double x0 = corner.x(), x1 = x0 + width, y0 = corner.y(), y1 = y0 + depth;
    for (const double x : {x0, x1 - 0.04})
        for (const double y : {y0, y1 - 0.04})
            append(mesh, box_mesh({x, y, 0}, {x + 0.04, y + 0.04, height}));
    for (int level = 0; level < 4; ++level) {
        const double z = 0.25 + (height - 0.3) / 3 * level;
        append(mesh, box_mesh({x0, y0, z - 0.03}, {x1, y1, z}));
        for (double x = x0 + 0.08; x + 0.2 < x1; x += draw.uniform(0.3, 0.55)) {
            const double w = draw.uniform(0.12, 0.28), h = draw.uniform(0.1, 0.4);
            if (level < 3) append(mesh, box_mesh({x, y0 + 0.05, z}, {std::min(x + w, x1), y1 - 0.05, z + h}));
        }
    }
}

RigidTransform turned(double x, double y, double turn) {
    return {Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {x, y, 0}};
}

}  // namespace

SurfaceMesh scenery_mesh(const Box& cell, bool clutter, uint64_t seed) {
    constexpr double beyond = 6.0;
    SurfaceMesh mesh = box_mesh({cell.min.x() - beyond, cell.min.y() - beyond, -0.1},
                                {cell.max.x() + beyond, cell.max.y() + beyond, 0});
    if (!clutter) return mesh;
    DrawSequence draw(seed, 31);
    const double left = cell.min.x(), right = cell.max.x(), back = cell.max.y();

    // Behind the cell.
    append(mesh, box_mesh({left - 2, back + 1.6, 0}, {right + 2, back + 1.7, 3}));
    add_shelf(mesh, {left + draw.uniform(0.1, 0.4), back + 0.8}, 1.4, 0.45, 2.0, draw);
    add_shelf(mesh, {right - 1.5 - draw.uniform(0.0, 0.3), back + 0.75}, 1.2, 0.5, 1.8, draw);
    append(mesh, box_mesh({-0.3, -0.3, 0}, {0.3, 0.3, draw.uniform(0.6, 1.1)},
                          turned(draw.uniform(-0.3, 0.3), back + 0.7, 0.5)));

    // Inside: a bench and boxes along the back edge, a bin in a front corner, clear of all ways.
    const double bench = draw.uniform(0.75, 0.9);
    const RigidTransform at_bench = turned(right - 0.75, back - 0.25, draw.uniform(-0.06, 0.06));
    append(mesh, box_mesh({-0.6, -0.2, bench - 0.04}, {0.6, 0.2, bench}, at_bench));
    for (const double x : {-0.55, 0.5})
        append(mesh, box_mesh({x, -0.18, 0}, {x + 0.05, 0.18, bench - 0.04}, at_bench));
    append(mesh, box_mesh({-0.4, -0.12, bench}, {-0.1, 0.1, bench + draw.uniform(0.08, 0.25)}, at_bench));
    append(mesh, box_mesh({-0.2, -0.15, 0}, {0.2, 0.15, draw.uniform(0.3, 0.6)},
                          turned(left + 0.4, back - 0.22, draw.uniform(-0.4, 0.4))));
    const Eigen::Vector3d bin(right - 0.3, cell.min.y() + 0.3, 0);
    append(mesh, cylinder_mesh(bin, bin + Eigen::Vector3d(0, 0, draw.uniform(0.45, 0.7)), 0.2));
    return mesh;
}

SurfaceMesh trolley_mesh(const MeshBounds& part) {
    const double half = 0.97, front = 0.06, back = 0.52;
    SurfaceMesh mesh = box_mesh({-half, front, 0.16}, {half, front + 0.05, 0.21});
    append(mesh, box_mesh({-half, back - 0.05, 0.16}, {half, back, 0.21}));
    for (const double x : {-half, -0.4, 0.36, half - 0.05})
        append(mesh, box_mesh({x, front, 0.16}, {x + 0.05, back, 0.2}));
    for (const double x : {-half, half}) {
        for (const double y : {front, back}) append(mesh, cylinder_mesh({x, y, 0.16}, {x, y, 1.02}, 0.02));
        append(mesh, cylinder_mesh({x, front, 1.02}, {x, back, 1.02}, 0.018));
    }
    for (const double x : {-half + 0.1, half - 0.1})
        for (const double y : {front, back})
            append(mesh, cylinder_mesh({x - 0.02, y, 0.08}, {x + 0.02, y, 0.08}, 0.08));

    // Two forks carry the part from below; they end just under its lower edge, behind its front.
    const double low = part.min.z() - 0.01, middle = 0.5 * (part.min.y() + part.max.y());
    for (const double x : {-0.38, 0.38}) {
        append(mesh, cylinder_mesh({x, back - 0.1, 0.2}, {x, back - 0.1, std::max(low, 0.25)}, 0.02));
        append(mesh,
               box_mesh({x - 0.02, std::min(middle, back - 0.12), low - 0.04}, {x + 0.02, back - 0.08, low}));
    }
    return mesh;
}

}  // namespace deixis
