// Depth images of analytic scenes (floor, boxes, capsules) for the tests of volume and gestures, with noise
// dials.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// A round limb from a to b [m], world frame.
struct Capsule {
    Eigen::Vector3d a, b;
    double radius = 0.05;
};

/// What stands on the floor z = 0.
struct DepthScene {
    std::vector<Capsule> capsules;
    std::vector<Box> boxes;
    bool floor = true;
};

struct SceneNoise {
    double step_per_m2 = 0;  ///< disparity step [m/m^2], 0 = exact
    double dropout = 0;      ///< share of pixels without measurement
    uint32_t seed = 1;
};

/// A 320 x 240 sensor (or of the given size) at `place` that looks at `target`; z up in the world.
CalibratedSensor sensor_looking(const Eigen::Vector3d& place, const Eigen::Vector3d& target, int width = 320,
                                int height = 240);

/// Two sensors behind and above the worker, to the left and to the right, as in the shop.
std::vector<CalibratedSensor> two_sensors();

DepthImage render(const CalibratedSensor& sensor, const DepthScene& scene, const SceneNoise& noise = {});

/// What a noisy sensor makes of an exact image.
DepthImage with_noise(const DepthImage& exact, const SceneNoise& noise);

/// One frameset of all sensors.
Frameset render_all(const std::vector<CalibratedSensor>& sensors, const DepthScene& scene,
                    int64_t timestamp_us, const SceneNoise& noise = {});

/// The scene of a worker of `height` standing at (x, y), facing +y, arms hanging; append limbs to point.
std::vector<Capsule> standing_person(double x, double y, double height = 1.75);

/// Straight arm from the shoulder of `side` (-1 left, 1 right) of that person towards `target`, `reach` long.
Capsule stretched_arm(double x, double y, double height, int side, const Eigen::Vector3d& target,
                      double reach = 0.68);

}  // namespace deixis
