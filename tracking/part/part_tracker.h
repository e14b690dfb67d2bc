// Finds the part and follows it: framesets and surface points in, one part estimate a frameset out.
#pragma once

#include <memory>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/part/part_estimate.h"
#include "tracking/part/reference_model.h"
#include "tracking/volume/surface_points.h"

namespace deixis {

struct PartTrackerParams {
    int search_period = 10;        ///< framesets from one search attempt to the next
    double max_tilt_deg = 180;     ///< of the part's z axis against the world's; 180: stands in any attitude
    double found_fitness = 0.90;   ///< share of the visible reference points that a new pose must find
    double found_residual = 0.25;  ///< mean depth error of a new pose, in tolerances, at most
    double held_fitness = 0.75;    ///< as found_fitness, for a pose that is tracked
    double held_residual = 0.40;   ///< as found_residual, for a pose that is tracked
    double found_share_min =
        0.20;  ///< of the reference points turned to a sensor that must be found, not hidden
    double held_share_min = 0.08;  ///< as found_share_min, for a pose that is tracked
    double seen_through_max =
        0.04;                    ///< share of the judged reference points behind which a sensor sees farther
    double rival_margin = 0.07;  ///< a different pose within this residual of the best makes it ambiguous
    double lock_min = 0.0015;    ///< smallest eigenvalue of ICP's Hessian for a pose that cannot slide
    int confirm_frames = 3;      ///< framesets a found pose must hold before it counts as tracking
    int lost_frames = 3;         ///< framesets in a row without the part until it is searched again
    double rest_s = 0.5;         ///< the part must keep still this long to be at rest [s]
    double rest_mm = 5;          ///< ... within this [mm]
    double motion_mm = 6;        ///< a resting part that is farther off than this has moved [mm]
    int icp_points = 6000;       ///< of a frameset that ICP uses, at most
    InvalidSettings validate() const;
};

/// States. `absent`: nothing like the part was found by the last attempt. `searching`: not looked yet, or
/// something is being confirmed. `ambiguous`: poses that differ explain the scene alike, or the pose can
/// slide; `reason` says which. `tracking`: the pose holds. `lost`: it was tracked and is not seen; after a
/// failed search it is `absent`.
///
/// Time comes from the framesets only; every search is seeded by its own number: the same framesets give the
/// same estimates on every run and with any number of threads.
class PartTracker {
  public:
    using Params = PartTrackerParams;

    /// `depth_sensors` in the order of `Frameset::frames`; params must be valid.
    PartTracker(std::shared_ptr<const ReferenceModel> model, std::vector<CalibratedSensor> depth_sensors,
                Params params);
    ~PartTracker();
    PartTracker(PartTracker&&) noexcept;
    PartTracker& operator=(PartTracker&&) noexcept;

    /// `points` are the surface points of the same frameset, above the floor and inside the cell. The
    /// reference is valid until the next call. A frameset whose stamp does not rise resets nothing but counts
    /// as no motion time.
    const PartEstimate& update(const Frameset& frameset, const SurfacePoints& points);

    const PartEstimate& estimate() const;
    const ReferenceModel& model() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace deixis
