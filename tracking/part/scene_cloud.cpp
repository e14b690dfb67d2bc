// Cells by sorted keys, planes by the scatter of neighbouring cells.
#include "tracking/part/scene_cloud.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tracking/part/pose_evidence.h"

namespace deixis {
namespace {

constexpr int fewest_in_cell = 3;
constexpr int fewest_in_plane = 6;

/// Sensor, then z, y, x: neighbours along x are neighbours in order.
struct CellKey {
    uint64_t value;

    static CellKey of(const Eigen::Vector3f& p, unsigned sensor, float inverse_cell) {
        const Eigen::Vector3i c = (p * inverse_cell).array().floor().cast<int>() + 32768;
        return at(c, sensor);
    }
    static CellKey at(const Eigen::Vector3i& c, unsigned sensor) {
        return {(static_cast<uint64_t>(sensor) << 48) | (static_cast<uint64_t>(c.z() & 0xFFFF) << 32) |
                (static_cast<uint64_t>(c.y() & 0xFFFF) << 16) | static_cast<uint64_t>(c.x() & 0xFFFF)};
    }
    bool operator<(const CellKey& other) const { return value < other.value; }
};

struct Cell {
    CellKey key;
    Eigen::Vector3f mean;
    unsigned sensor;
};

std::vector<Cell> averaged(const SurfacePoints& points, bool foreground_only, float inverse_cell) {
    std::vector<std::pair<uint64_t, uint32_t>> order;
    for (uint32_t i = 0; i < points.size(); ++i) {
        if ((foreground_only && points.foreground[i] == 0) || !points.positions[i].allFinite()) continue;
        if (points.positions[i].cwiseAbs().maxCoeff() * inverse_cell > 32000) continue;
        order.emplace_back(CellKey::of(points.positions[i], points.sensor[i], inverse_cell).value, i);
    }
    std::sort(order.begin(), order.end());
    std::vector<Cell> cells;
    for (size_t from = 0, to = 0; from < order.size(); from = to) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (to = from; to < order.size() && order[to].first == order[from].first; ++to)
            sum += points.positions[order[to].second];
        if (to - from >= fewest_in_cell)
            cells.push_back({{order[from].first},
                             sum / static_cast<float>(to - from),
                             points.sensor[order[from].second]});
    }
    return cells;
}

/// Plane through the cells of one sensor within `radius`; zero when they are few or spread like a line.
Eigen::Vector3f plane_normal(const std::vector<Cell>& cells, const Cell& cell, float inverse_cell,
                             float radius) {
    const Eigen::Vector3i middle = (cell.mean * inverse_cell).array().floor().cast<int>() + 32768;
    const int reach = static_cast<int>(std::ceil(radius * inverse_cell));
    Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    int count = 0;
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y) {
            const CellKey first = CellKey::at(middle + Eigen::Vector3i(-reach, y, z), cell.sensor);
            const CellKey last = CellKey::at(middle + Eigen::Vector3i(reach, y, z), cell.sensor);
            auto at = std::lower_bound(cells.begin(), cells.end(), first,
                                       [](const Cell& c, const CellKey& key) { return c.key < key; });
            for (; at != cells.end() && !(last < at->key); ++at) {
                const Eigen::Vector3f d = at->mean - cell.mean;
                if (d.squaredNorm() > radius * radius) continue;
                sum += d;
                scatter += d * d.transpose();
                ++count;
            }
        }
    if (count < fewest_in_plane) return Eigen::Vector3f::Zero();
    scatter -= sum * sum.transpose() / static_cast<float>(count);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
    solver.computeDirect(scatter);
    if (solver.eigenvalues()[1] < 0.05F * solver.eigenvalues()[2]) return Eigen::Vector3f::Zero();
    return solver.eigenvectors().col(0);
}

}  // namespace

SceneCloud thin_scene(const SurfacePoints& points, const std::vector<Eigen::Vector3d>& eyes,
                      bool foreground_only, double cell, double normal_radius, size_t most) {
    const auto inverse_cell = static_cast<float>(1 / cell);
    const std::vector<Cell> cells = averaged(points, foreground_only, inverse_cell);
    SceneCloud scene;
    const size_t kept = std::min(most, cells.size());
    for (size_t k = 0; k < kept; ++k) {
        const Cell& c = cells[k * cells.size() / kept];
        const Eigen::Vector3f eye = eyes[c.sensor].cast<float>();
        const Eigen::Vector3f to_eye = (eye - c.mean).normalized();
        Eigen::Vector3f normal = plane_normal(cells, c, inverse_cell, static_cast<float>(normal_radius));
        if (normal.dot(to_eye) < 0) normal = -normal;
        const auto sigma =
            static_cast<float>(0.003 + 0.3 * depth_step(static_cast<double>((eye - c.mean).norm())));
        scene.positions.push_back(c.mean);
        scene.normals.push_back(normal);
        scene.points.push_back({c.mean, to_eye, 1e-4F / (sigma * sigma)});
    }
    return scene;
}

}  // namespace deixis
