// The calibrated work cell as a value: sensors with lens and place, the volume of interest, the pointing
// axis.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "tracking/geometry/camera_model.h"
#include "tracking/geometry/rigid_transform.h"

namespace deixis {

enum class SensorKind { depth, infrared, video };

struct CalibratedSensor {
    std::string name;
    SensorKind kind = SensorKind::depth;
    CameraModel camera;
    RigidTransform camera_from_world;
    std::string uri;
};

/// Axis-aligned box of the world frame [m].
struct Box {
    Eigen::Vector3d min = Eigen::Vector3d::Zero();
    Eigen::Vector3d max = Eigen::Vector3d::Zero();

    bool contains(const Eigen::Vector3d& p) const {
        return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
    }
};

/// World frame: right-handed, Z up, floor at z = 0.
struct SensorRig {
    std::vector<CalibratedSensor> sensors;
    std::optional<Box> cell;                       ///< absent: what background and views bound
    std::optional<Eigen::Vector3d> pointing_axis;  ///< unit; absent: from the worker to the part
};

}  // namespace deixis
