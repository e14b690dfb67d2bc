// From a frameset to what the station knows of it: the stages in their order, each called once, timed.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "appliance/station/frame_result.h"
#include "appliance/station/work_cell.h"
#include "gestures/gesture_tracker.h"
#include "tracking/part/part_tracker.h"
#include "tracking/volume/carving.h"
#include "tracking/volume/foreground.h"
#include "tracking/volume/frame_gaps.h"
#include "tracking/volume/surface_fusion.h"
#include "tracking/volume/worker_volume.h"

namespace deixis {

struct PerceptionParams {
    FrameGaps::Params gaps;
    ForegroundModel::Params foreground;
    SurfaceFusion::Params surface;
    PartTracker::Params part;
    VoxelCarver::Params carving;
    WorkerVolume::Params worker;
    GestureTracker::Params gesture;
    double part_margin_m = 0.035;  ///< a surface point this near to the tracked CAD surface is the part's [m]
    int threads = 2;               ///< at most; the results are the same for any number
    InvalidSettings validate() const;
};

/// Deterministic: the same framesets give the same observations, whatever the clock, load or thread count.
class Perception {
  public:
    /// What one frameset gave, still without ids: the record has not seen the mark yet.
    struct Observation {
        FrameResult result;  ///< `marks` empty, `stage_ms.record` and `.total` zero
        std::optional<Mark> mark;
        bool worker_present = false;
    };

    /// `cell` is read during construction and its part model kept; `params` must be valid.
    Perception(const WorkCell& cell, const PerceptionParams& params);
    ~Perception();

    /// Framesets with `frames` in the order of `cell.rig.sensors`.
    Observation update(const Frameset& paired);

    /// The worker's voxels of the last frameset as centres [m], world frame.
    void worker_voxels(std::vector<Eigen::Vector3f>& centres) const;
    float voxel_size() const;

  private:
    struct Stages;
    std::unique_ptr<Stages> stages_;
};

}  // namespace deixis
