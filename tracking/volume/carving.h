// Voxel carving from depth images (thesis 3.1): which voxels are free, occupied or unknown.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/volume/foreground.h"
#include "tracking/volume/voxel_grid.h"

namespace deixis {

/// One sensor as the carving kernels see it: voxel centre to camera frame, lens, and an image of signed
/// depths.
struct CarvingView {
    int width = 0, height = 0;
    std::array<float, 12> camera_from_world{};  ///< 3 x 4, row-major
    float fx = 0, fy = 0, cx = 0, cy = 0;
    bool distorted = false;
    std::array<float, 5> distortion{};
    float max_radius2 = 0;     ///< squared x/z, y/z radius up to which the lens polynomial is rising
    std::vector<float> depth;  ///< [m]; > 0 foreground, < 0 background (negated), 0 = no measurement
};

/// For each voxel centre at depth d and the pixel it falls on with depth D (compared as z, not range):
///   eq. 3.3   d < D - slack in any view            -> free
///   eq. 3.4   D - slack <= d <= D + penetration at a foreground pixel of some view -> occupied, unless free
///   else                                            -> unknown
/// With several views a voxel that one of them sees deep behind a surface is not carved by it (as 3.4 would
/// for a single view): that view is only blind there. Nothing is carved behind a camera, outside its image,
/// beyond the reach of its lens model, or where it has no depth.
class VoxelCarver {
  public:
    struct Params {
        double voxel_m = 0.03;         ///< side of a voxel [m]
        double penetration_m = 0.10;   ///< Delta of eq. 3.4 [m]
        double slack_m = 0.015;        ///< noise margin of eq. 3.3 at zero distance [m]
        double step_per_m2 = 2.85e-3;  ///< disparity step [m/m^2]
        double slack_steps = 1.0;      ///< noise margin in disparity steps, added to slack_m

        InvalidSettings validate() const;
    };

    VoxelCarver(const std::vector<CalibratedSensor>& depth_sensors, const Box& cell, Params params);

    /// The whole grid for this frameset; valid until the next update. Sensors that are absent do not carve.
    /// The same, bit for bit, whatever SIMD the machine has.
    const VoxelGrid& update(const Frameset& frameset, const ForegroundModel& foreground);

    const VoxelGrid& grid() const { return grid_; }
    const std::vector<CarvingView>& views() const { return views_; }
    const Params& params() const { return params_; }

  private:
    Params params_;
    std::vector<CarvingView> views_;
    std::vector<const CarvingView*> present_;
    VoxelGrid grid_;
};

}  // namespace deixis
