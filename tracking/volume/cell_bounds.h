// The volume of interest when the calibration names none. In: sensors, backgrounds; out: a box of the world
// frame.
#pragma once

#include <optional>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// The cell of the calibration, if it has one. Else the box of the background points (trimmed by 1 % a side,
/// in x and y); without background the floor within 4.5 m of each sensor along its view. Never larger than 8
/// m by 8 m, height 0 to 2.3 m. With no sensor at all: 4 x 3 x 2.3 m around the origin.
Box cell_bounds(const SensorRig& rig, const std::vector<CalibratedSensor>& depth_sensors,
                const std::vector<std::optional<DepthImage>>& background);

}  // namespace deixis
