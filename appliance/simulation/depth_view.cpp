// Primary and shadow rays of one sensor.
#include "appliance/simulation/depth_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deixis {
namespace {

constexpr float nearest = 0.05F;  // a lens is not looked at from inside [m]

struct LocalRays {
    const RayCaster* caster;
    Eigen::Matrix3f rotation;  ///< object_from_world
    Eigen::Vector3f translation;

    explicit LocalRays(const ViewedObject& object)
        : caster(object.caster),
          rotation(object.world_from_object.rotation.transpose().cast<float>()),
          translation(object.world_from_object.inverse().translation.cast<float>()) {}

    std::optional<RayHit> cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float from,
                               float to) const {
        return caster->cast(rotation * origin + translation, rotation * direction, from, to);
    }
};

}  // namespace

DepthView::DepthView(const CalibratedSensor& sensor, double baseline) : sensor_(sensor), baseline_(baseline) {
    const RigidTransform world_from_camera = sensor.camera_from_world.inverse();
    eye_ = world_from_camera.translation.cast<float>();
    projector_ = (world_from_camera * Eigen::Vector3d(baseline, 0, 0)).cast<float>();
    ray_.reserve(static_cast<size_t>(width()) * height());
    for (int v = 0; v < height(); ++v)
        for (int u = 0; u < width(); ++u)
            ray_.emplace_back((world_from_camera.rotation * sensor.camera.ray({u, v})).cast<float>());
}

DepthLayer DepthView::empty_layer() const {
    return {std::vector<float>(ray_.size(), std::numeric_limits<float>::infinity()),
            std::vector<float>(ray_.size(), 0), std::vector<uint8_t>(ray_.size(), 0)};
}

void DepthView::overlay(DepthLayer& layer, const ViewedObject& object, const std::vector<ViewedObject>& below,
                        const PixelBox& box) const {
    const LocalRays self(object);
    std::vector<LocalRays> others;
    others.reserve(below.size());
    for (const ViewedObject& other : below) others.emplace_back(other);
    // A hair short of the spot itself, which would otherwise shade itself.
    constexpr float before_spot = 1.0F - 1.5e-3F;
    const auto shades = [&](const LocalRays& rays, size_t i) {
        const Eigen::Vector3f spot = eye_ + layer.z[i] * ray_[i];
        return rays.cast(projector_, spot - projector_, 0, before_spot).has_value();
    };
    std::vector<uint8_t> is_object(ray_.size(), 0);
    float z_min = std::numeric_limits<float>::infinity();
    for (int v = box.v0; v < box.v1; ++v)
        for (int u = box.u0; u < box.u1; ++u) {
            const size_t i = static_cast<size_t>(v) * width() + u;
            const auto hit = self.cast(eye_, ray_[i], nearest, layer.z[i]);
            if (!hit) continue;
            is_object[i] = 1;
            layer.z[i] = hit->distance;
            z_min = std::min(z_min, hit->distance);
            layer.cosine[i] =
                std::abs((self.rotation.transpose() * hit->normal).dot(ray_[i])) / ray_[i].norm();
            layer.shaded[i] =
                shades(self, i) || std::any_of(others.begin(), others.end(),
                                               [&](const LocalRays& other) { return shades(other, i); });
        }
    if (!std::isfinite(z_min)) return;
    // Behind it: only pixels with the object within the shadow's reach to their right, a few rows up or down
    // for the lens, or beyond the image's edge, can lie in its shadow.
    const int reach = shadow_reach(z_min), rows = 3;
    const int edge = baseline_ > 0 ? width() - 1 : 0, step = baseline_ > 0 ? -1 : 1;
    for (int v = box.v0; v < box.v1; ++v) {
        int since = reach + 1;
        for (int u = baseline_ > 0 ? box.u1 - 1 : box.u0; u >= box.u0 && u < box.u1; u += step) {
            for (int row = std::max(v - rows, box.v0); row <= std::min(v + rows, box.v1 - 1); ++row)
                if (is_object[static_cast<size_t>(row) * width() + u] != 0) since = 0;
            if (u == edge) since = 0;
            const size_t i = static_cast<size_t>(v) * width() + u;
            if (since++ <= reach && is_object[i] == 0 && layer.shaded[i] == 0 && std::isfinite(layer.z[i]))
                layer.shaded[i] = shades(self, i) ? 1 : 0;
        }
    }
}

int DepthView::shadow_reach(double z) const {
    return static_cast<int>(std::ceil(sensor_.camera.fx * std::abs(baseline_) / z)) + 2;
}

PixelBox DepthView::footprint(const std::vector<Eigen::Vector3f>& points,
                              const RigidTransform& world_from_points) const {
    const RigidTransform camera_from_points = sensor_.camera_from_world * world_from_points;
    const CameraModel& camera = sensor_.camera;
    // Lenses fold back far outside the image: rays twice as wide as the image's corner are not projected.
    const double widest = 2 * std::max({camera.ray({0, 0}).head<2>().norm(),
                                        camera.ray({width() - 1.0, height() - 1.0}).head<2>().norm()});
    PixelBox box{width(), height(), 0, 0};
    bool outside = true;
    double z_min = 1e9;
    for (const Eigen::Vector3f& point : points) {
        const Eigen::Vector3d p = camera_from_points * point.cast<double>();
        if (p.z() < 0.1) {
            if (p.norm() < 0.5) return whole();
            continue;
        }
        if (p.head<2>().norm() > widest * p.z()) continue;
        const Eigen::Vector2d pixel = camera.project(p);
        z_min = std::min(z_min, p.z());
        box.u0 = std::min(box.u0, static_cast<int>(std::floor(std::clamp(pixel.x(), -1e4, 1e4))) - 2);
        box.v0 = std::min(box.v0, static_cast<int>(std::floor(std::clamp(pixel.y(), -1e4, 1e4))) - 2);
        box.u1 = std::max(box.u1, static_cast<int>(std::ceil(std::clamp(pixel.x(), -1e4, 1e4))) + 3);
        box.v1 = std::max(box.v1, static_cast<int>(std::ceil(std::clamp(pixel.y(), -1e4, 1e4))) + 3);
        outside = false;
    }
    if (outside) return {};
    // The shadow falls to the left, by the disparity of the nearest point at most (right for a projector at
    // left).
    const int shadow = shadow_reach(z_min);
    (baseline_ > 0 ? box.u0 : box.u1) += baseline_ > 0 ? -shadow : shadow;
    box.v0 -= 4;
    box.v1 += 4;
    return {std::max(box.u0, 0), std::max(box.v0, 0), std::min(box.u1, width()), std::min(box.v1, height())};
}

}  // namespace deixis
