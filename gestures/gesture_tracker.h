// From the worker of a frame to the ray he points along and the mark he means: arms, ray, dwell in one call a
// frame.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "gestures/mark.h"
#include "tracking/geometry/ray_caster.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/rigid_transform.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/volume/surface_points.h"
#include "tracking/volume/worker_volume.h"

namespace deixis {

/// All of one frameset. References live only during the call.
struct GestureInput {
    int64_t timestamp_us = 0;
    const WorkerBody& worker;
    const SurfacePoints& points;
    std::span<const uint8_t> part_points;           ///< as given to WorkerVolume
    const RayCaster* part_surface = nullptr;        ///< part frame [m]; null = no part loaded
    std::optional<RigidTransform> world_from_part;  ///< set exactly while the part is tracked
    bool part_at_rest = false;
};

struct GestureOutput {
    std::optional<PointingRay> ray;  ///< of the arm that points, null when none does
    std::optional<Mark> mark;        ///< on the frame that completes a dwell
};

/// Deterministic; depends on time only through the stamps. After a jump back of the stamps it starts afresh.
class GestureTracker {
  public:
    struct Params {
        double dwell_s = 1.0;      ///< how long a point is held to be a mark [s]
        double eye_weight = 0.3;   ///< 0 = along the forearm, 1 = from the eye through the fingertip
        double max_reach_m = 1.2;  ///< a hit farther than this from the fingertip is none [m]
        double touch_m = 0.03;     ///< fingertip this near to the surface touches it [m]

        InvalidSettings validate() const;
    };

    /// `rig` gives the pointing axis (optional) and the places of the depth sensors.
    GestureTracker(const SensorRig& rig, Params params);
    ~GestureTracker();
    GestureTracker(GestureTracker&&) noexcept;
    GestureTracker& operator=(GestureTracker&&) noexcept;

    GestureOutput update(const GestureInput& input);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace deixis
