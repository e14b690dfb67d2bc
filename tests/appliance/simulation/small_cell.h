// A small cell for tests: a curved panel as the part, low resolution, a short script.
#pragma once

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

}  // namespace deixis
