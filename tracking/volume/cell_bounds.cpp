// A box from background points or, failing them, from where the sensors look.
#include "tracking/volume/cell_bounds.h"

#include <algorithm>

namespace deixis {
namespace {

constexpr double kHeight = 2.3;     // [m]
constexpr double kLargest = 8.0;    // side of the box [m]
constexpr double kViewReach = 4.5;  // how far a depth sensor of this class is of use [m]
constexpr int kPixelStep = 8;

struct Footprint {
    std::vector<double> x, y;

    void add(const Eigen::Vector3d& p) {
        x.push_back(p.x());
        y.push_back(p.y());
    }
};

void add_background(Footprint& footprint, const CalibratedSensor& sensor, const DepthImage& image) {
    const RigidTransform world_from_camera = sensor.camera_from_world.inverse();
    for (int v = 0; v < image.height; v += kPixelStep)
        for (int u = 0; u < image.width; u += kPixelStep) {
            const double z = image.at(u, v) / 1000.0;
            if (z <= 0 || z > 2 * kViewReach) continue;
            const Eigen::Vector3d p = world_from_camera * (z * sensor.camera.ray({u, v}));
            if (p.z() > -0.2 && p.z() < kHeight) footprint.add(p);
        }
}

/// What the view sees of the floor, at most kViewReach of depth away; rays that miss the floor end at that
/// depth.
void add_view(Footprint& footprint, const CalibratedSensor& sensor) {
    const RigidTransform world_from_camera = sensor.camera_from_world.inverse();
    for (int v = 0; v < sensor.camera.height; v += 4 * kPixelStep)
        for (int u = 0; u < sensor.camera.width; u += 4 * kPixelStep) {
            const Eigen::Vector3d ray = world_from_camera.rotation * sensor.camera.ray({u, v});
            double z = kViewReach;
            if (ray.z() < 0) z = std::min(z, -world_from_camera.translation.z() / ray.z());
            if (z > 0) footprint.add(world_from_camera.translation + z * ray);
        }
}

void trimmed_range(std::vector<double>& values, double share, double& low, double& high) {
    const auto cut = static_cast<size_t>(share * static_cast<double>(values.size() - 1));
    std::sort(values.begin(), values.end());
    low = values[cut];
    high = values[values.size() - 1 - cut];
    const double middle = (low + high) / 2;
    low = std::max(low, middle - kLargest / 2);
    high = std::min(high, middle + kLargest / 2);
}

}  // namespace

Box cell_bounds(const SensorRig& rig, const std::vector<CalibratedSensor>& depth_sensors,
                const std::vector<std::optional<DepthImage>>& background) {
    if (rig.cell) return *rig.cell;
    Footprint footprint;
    for (size_t s = 0; s < depth_sensors.size() && s < background.size(); ++s) {
        const CameraModel& camera = depth_sensors[s].camera;
        if (background[s] && background[s]->width == camera.width && background[s]->height == camera.height)
            add_background(footprint, depth_sensors[s], *background[s]);
    }
    double trim = 0.01;
    if (footprint.x.size() < 100) {
        trim = 0;
        for (const CalibratedSensor& sensor : depth_sensors) add_view(footprint, sensor);
    }
    Box box{{-2, -1.5, 0}, {2, 1.5, kHeight}};
    if (footprint.x.empty()) return box;
    trimmed_range(footprint.x, trim, box.min.x(), box.max.x());
    trimmed_range(footprint.y, trim, box.min.y(), box.max.y());
    return box;
}

}  // namespace deixis
