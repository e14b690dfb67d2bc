// From the worker of a frame to the ray he points along and the mark he means: arms, ray, dwell in one call a
// frame.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gestures/arm.h"
#include "gestures/dwell.h"
#include "gestures/limbs.h"
#include "gestures/mark.h"
#include "gestures/pointing.h"
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
        double reach_out_m =
            0.22;  ///< fingertip from the middle of the body towards the spot, horizontally [m]
        LimbFinder::Params limbs;
        ArmFinder::Params arms;
        PointingParams pointing;
        DwellDetector::Params stillness;

        InvalidSettings validate() const;
    };

    /// `rig` gives the main axis of pointing (optional) and the places of its depth sensors, in the order of
    /// `SurfacePoints::sensor`.
    GestureTracker(const SensorRig& rig, const Params& params);

    /// Both arms are followed (thesis 5.1.2: a cluster goes on as the closest one of the frame before); of
    /// two that point, the ray is the one whose hit is nearer to its fingertip.
    GestureOutput update(const GestureInput& input);

    /// The arms of the last update that reach out, whether or not they hit the part.
    const std::vector<ArmCluster>& arms() const { return arms_.arms(); }

  private:
    /// One arm over time.
    struct Track {
        explicit Track(const DwellDetector::Params& params) : dwell(params) {}
        DwellDetector dwell;
        std::optional<Eigen::Vector3d> last_tip;
        std::optional<PointingRay> ray;
        double distance = 0;  ///< from fingertip to hit [m]
    };

    std::optional<Eigen::Vector3d> forward_of(const GestureInput& input) const;
    void follow(const GestureInput& input);
    void aim(const GestureInput& input, const ArmCluster& arm, Track& track) const;

    Params params_;
    std::optional<Eigen::Vector3d> axis_;
    LimbFinder limbs_;
    ArmFinder arms_;
    std::vector<Track> tracks_;
};

}  // namespace deixis
