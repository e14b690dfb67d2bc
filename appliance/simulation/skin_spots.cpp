// Area-weighted drawing with ray checks.
#include "appliance/simulation/skin_spots.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace deixis {

SkinSpots::SkinSpots(const SurfaceMesh& mesh, const RayCaster& caster, const Eigen::Vector3d& towards_worker)
    : mesh_(mesh), caster_(caster), towards_worker_(towards_worker) {
    if (mesh.vertices.empty()) return;
    const MeshBounds bounds = bounds_of(mesh);
    middle_ = 0.5 * (bounds.min + bounds.max).cast<double>();
    half_width_ = 0.5 * (bounds.max - bounds.min).cast<double>().maxCoeff();
    double area = 0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (triangle_normal(mesh, t).cast<double>().dot(towards_worker) < 0.5) continue;
        const auto& [a, b, c] = mesh.triangles[t];
        area += 0.5 * (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm();
        facing_.push_back(static_cast<uint32_t>(t));
        area_before_.push_back(area);
    }
}

std::optional<SkinSpot> SkinSpots::seen_at(const Eigen::Vector3d& position,
                                           const Eigen::Vector3d& normal) const {
    constexpr double out = 0.5;
    const Eigen::Vector3d from = position + out * towards_worker_;
    const auto hit = caster_.cast(from.cast<float>(), (-towards_worker_).cast<float>(), 0, 1.0F);
    if (!hit || std::abs(hit->distance - out) > 0.004) return std::nullopt;
    return SkinSpot{position, normal};
}

std::optional<SkinSpot> SkinSpots::draw(DrawSequence& draw) const {
    if (facing_.empty()) return std::nullopt;
    for (int attempt = 0; attempt < 500; ++attempt) {
        const double area = draw.uniform(0, area_before_.back());
        const size_t i = std::min<size_t>(
            std::upper_bound(area_before_.begin(), area_before_.end(), area) - area_before_.begin(),
            facing_.size() - 1);
        double u = draw.uniform(0, 1), v = draw.uniform(0, 1);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const auto& [a, b, c] = mesh_.triangles[facing_[i]];
        const Eigen::Vector3d pa = mesh_.vertices[a].cast<double>(), pb = mesh_.vertices[b].cast<double>(),
                              pc = mesh_.vertices[c].cast<double>();
        const Eigen::Vector3d position = pa + u * (pb - pa) + v * (pc - pa);
        const Eigen::Vector3d normal = triangle_normal(mesh_, facing_[i]).cast<double>();
        if (!seen_at(position, normal)) continue;
        const Eigen::Vector3d side = normal.unitOrthogonal(), up = normal.cross(side);
        bool clear = true;
        for (int k = 0; k < 8 && clear; ++k) {  // a ring of 4 cm around it lies on skin too
            const double angle = k * 0.7853981633974483;
            const Eigen::Vector3d from =
                position + 0.04 * (std::cos(angle) * side + std::sin(angle) * up) + 0.1 * normal;
            const auto hit = caster_.cast(from.cast<float>(), (-normal).cast<float>(), 0, 0.2F);
            clear = hit && std::abs(hit->distance - 0.1F) < 0.025F;
        }
        if (clear) return SkinSpot{position, normal};
    }
    return std::nullopt;
}

std::optional<SkinSpot> SkinSpots::at(const Eigen::Vector3d& position) const {
    const auto near = caster_.nearest(position.cast<float>(), 0.005F);
    if (!near) return std::nullopt;
    Eigen::Vector3d normal = near->normal.cast<double>();
    if (normal.dot(towards_worker_) < 0) normal = -normal;  // the inner face of a thin shell lies as near
    return seen_at(position, normal);
}

}  // namespace deixis
