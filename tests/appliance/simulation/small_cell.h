// A small cell for tests: a curved panel as the part, low resolution, a short script.
#pragma once

#include <Eigen/Core>
#include <string>

#include "appliance/simulation/scenario.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

/// Thin curved shell, 1.6 m wide, 0.4 m high, 3 mm thick, outer skin to -y; origin in the middle of its lower
/// edge.
SurfaceMesh curved_panel();

/// Scenario text: two sensors of 160x120 pixels, a worker, the panel, and what `actions` adds at the end.
std::string small_scenario(const std::string& actions);

/// `small_scenario` parsed; fails the test when it is refused.
Scenario parsed(const std::string& text);

/// `text` with the first `from` made `to`; fails the test when there is none.
std::string replaced(std::string text, const std::string& from, const std::string& to);

/// How far `p` lies off the line through `a` and `b`.
double distance_off_line(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace deixis
