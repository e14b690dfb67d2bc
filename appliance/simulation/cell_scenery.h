// Meshes of what is no worker and no part: floor, clutter behind and inside the cell, the trolley.
#pragma once

#include <cstdint>

#include "tracking/geometry/rigid_transform.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

/// Closed box, outward triangles, `world_from_box` applied.
SurfaceMesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                     const RigidTransform& world_from_box = {});

/// Closed cylinder with round caps between two different points.
SurfaceMesh cylinder_mesh(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius,
                          int sides = 16);

/// World frame. The floor reaches 6 m beyond `cell`; with `clutter` a wall, shelves and boxes stand behind
/// the cell and a bench, boxes and a bin inside, all clear of the worker's and the trolley's ways; their
/// sizes follow the seed.
SurfaceMesh scenery_mesh(const Box& cell, bool clutter, uint64_t seed);

/// Grips of the trolley, trolley frame (origin on the floor below its middle, x along it, -y to the worker).
struct TrolleyGrips {
    Eigen::Vector3d end_left{-0.97, 0.12, 1.02};  ///< handle bar at the -x end; mirror x for the other end
    Eigen::Vector3d end_right{-0.97, 0.46, 1.02};
    Eigen::Vector3d corner{-0.97, 0.06,
                           1.02};  ///< top of the front post at the -x end; mirror x for the other
};

/// Trolley frame: base with four wheels, two end posts with handle bars, and supports that reach up to just
/// below and behind a part whose box (trolley frame) is `part`.
SurfaceMesh trolley_mesh(const MeshBounds& part);

}  // namespace deixis
