// Depth pixels to world points with normals, by ray tables; all arithmetic in float.
#include "tracking/volume/surface_fusion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace deixis {
namespace {

/// Reads one depth image around one pixel; offers the differences that a normal needs.
struct PixelSurface {
    const uint16_t* mm;
    const Eigen::Vector2f* rays;
    int width, height;

    Eigen::Vector3f point(int u, int v, float z) const {
        const Eigen::Vector2f& ray = rays[static_cast<size_t>(v) * width + u];
        return {ray.x() * z, ray.y() * z, z};
    }

    /// Point `reach` pixels away along (du, dv), or nearer to the pixel where that is over an edge; false
    /// when none.
    bool step(int u, int v, int du, int dv, int reach, int z_mm, int edge, Eigen::Vector3f& out) const {
        for (int r = reach; r >= 1; r = r > 2 ? r / 2 : r - 1) {
            const int x = u + r * du, y = v + r * dv;
            if (x < 0 || y < 0 || x >= width || y >= height) continue;
            const int d = mm[static_cast<size_t>(y) * width + x];
            if (d == 0 || std::abs(d - z_mm) > edge) continue;
            out = point(x, y, static_cast<float>(d) * 0.001F);
            return true;
        }
        return false;
    }

    /// Unit, towards the sensor; zero where a direction has no like neighbour.
    Eigen::Vector3f normal(int u, int v, int z_mm, int reach, int edge) const {
        Eigen::Vector3f left = point(u, v, static_cast<float>(z_mm) * 0.001F);
        Eigen::Vector3f right = left, up = left, down = left;
        const bool l = step(u, v, -1, 0, reach, z_mm, edge, left),
                   r = step(u, v, 1, 0, reach, z_mm, edge, right);
        const bool a = step(u, v, 0, -1, reach, z_mm, edge, up),
                   b = step(u, v, 0, 1, reach, z_mm, edge, down);
        if (!(l || r) || !(a || b)) return Eigen::Vector3f::Zero();
        const Eigen::Vector3f n = (down - up).cross(right - left);
        const float length = n.norm();
        if (!(length > 1e-12F)) return Eigen::Vector3f::Zero();
        return n.dot(left) > 0 ? Eigen::Vector3f(-n / length) : Eigen::Vector3f(n / length);
    }
};

}  // namespace

InvalidSettings SurfaceFusion::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "stride", stride, 1, 16);
    require_range(complaints, "floor_m", floor_m, -1, 2);
    require_range(complaints, "max_depth_m", max_depth_m, 0.1, 65.534);
    require_range(complaints, "normal_reach", normal_reach, 1, 16);
    require_range(complaints, "step_per_m2", step_per_m2, 0, 0.1);
    require_range(complaints, "edge_steps", edge_steps, 0, 20);
    return complaints;
}

SurfaceFusion::SurfaceFusion(const std::vector<CalibratedSensor>& depth_sensors, std::optional<Box> cell,
                             Params params)
    : params_(params), cell_(std::move(cell)) {
    for (const CalibratedSensor& s : depth_sensors) {
        PerSensor& sensor = sensors_.emplace_back();
        sensor.width = s.camera.width;
        sensor.height = s.camera.height;
        sensor.rays = s.camera.ray_table();
        const RigidTransform world_from_camera = s.camera_from_world.inverse();
        sensor.world_from_camera = world_from_camera.rotation.cast<float>();
        sensor.place = world_from_camera.translation.cast<float>();
    }
}

const SurfacePoints& SurfaceFusion::update(const Frameset& frameset, const ForegroundModel& foreground) {
    points_.clear();
    for (size_t s = 0; s < sensors_.size() && s < frameset.frames.size(); ++s) {
        const DepthFrame& frame = frameset.frames[s];
        if (frame.present && frame.depth.width == sensors_[s].width &&
            frame.depth.height == sensors_[s].height)
            fuse(s, frame.depth, foreground.mask(s));
    }
    return points_;
}

void SurfaceFusion::fuse(size_t index, const DepthImage& depth, std::span<const uint8_t> mask) {
    const PerSensor& sensor = sensors_[index];
    const PixelSurface surface{depth.millimetres.data(), sensor.rays.data(), sensor.width, sensor.height};
    const Eigen::Matrix3f rotation = sensor.world_from_camera;
    const int farthest = static_cast<int>(params_.max_depth_m * 1000);
    constexpr float kFar = 1e6F;
    Eigen::Vector3f low(-kFar, -kFar, -kFar), high(kFar, kFar, kFar);
    if (cell_) {
        low = cell_->min.cast<float>();
        high = cell_->max.cast<float>();
    }
    low.z() = std::max(low.z(), static_cast<float>(params_.floor_m));
    const auto step_mm = static_cast<float>(params_.edge_steps * params_.step_per_m2 * 1e-3);
    for (int v = 0; v < sensor.height; ++v) {
        const size_t row = static_cast<size_t>(v) * sensor.width;
        const bool full_row = v % params_.stride == 0;
        for (int u = 0; u < sensor.width; ++u) {
            const bool is_foreground = mask[row + u] != 0;
            if (!is_foreground && !(full_row && u % params_.stride == 0)) continue;
            const int d = depth.millimetres[row + u];
            if (d == 0 || d > farthest) continue;
            const Eigen::Vector3f p =
                rotation * surface.point(u, v, static_cast<float>(d) * 0.001F) + sensor.place;
            if (!((p.array() >= low.array()).all() && (p.array() <= high.array()).all())) continue;
            const int edge = 20 + static_cast<int>(step_mm * static_cast<float>(d) * static_cast<float>(d));
            const Eigen::Vector3f n = surface.normal(u, v, d, params_.normal_reach, edge);
            // Without a like neighbour in both directions it hangs in the air; the foreground's were asked
            // already.
            if (!is_foreground && n.isZero()) continue;
            points_.positions.push_back(p);
            points_.normals.emplace_back(rotation * n);
            points_.sensor.push_back(static_cast<uint8_t>(index));
            points_.foreground.push_back(is_foreground ? 1 : 0);
        }
    }
}

}  // namespace deixis
