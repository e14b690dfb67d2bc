// What the depth images say for and against a pose: reference points projected into them, found, seen through
// or hidden.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/rigid_transform.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/part/outer_skin.h"

namespace deixis {

/// Depth error to allow for at depth z [m]: one disparity step of a structured-light sensor, 2.85e-3 z^2,
/// taken for any.
inline double depth_step(double z) {
    return 2.85e-3 * z * z;
}

/// Counts over (reference point, sensor) pairs in which the part itself does not hide the point and the pixel
/// is in the image.
struct PoseEvidence {
    int facing = 0;        ///< all pairs
    int found = 0;         ///< the image shows a surface there
    int off = 0;           ///< a surface nearby, but not there
    int seen_through = 0;  ///< the image sees clearly farther: no part can be there
    int hidden = 0;        ///< something stands clearly in front
    double residual = 0;   ///< mean of min(|depth error| / tolerance, 1) over found, off and seen through

    int judged() const { return found + off + seen_through; }
    double fitness() const { return judged() > 0 ? static_cast<double>(found) / judged() : 0; }
    double found_share() const { return facing > 0 ? static_cast<double>(found) / facing : 0; }
    double seen_through_share() const {
        return judged() > 0 ? static_cast<double>(seen_through) / judged() : 0;
    }
};

/// A frameset made ready to be asked about many poses. Holds pointers to its arguments: they must outlive it.
class DepthWitness {
  public:
    DepthWitness(const std::vector<CalibratedSensor>& sensors, const Frameset& frameset);

    /// Every `stride`-th point of `points` (from `first`) under the pose; `slack` [m] is added to the
    /// tolerance along the surface normal that `found` allows.
    PoseEvidence ask(const RigidTransform& world_from_part, const std::vector<SkinPoint>& points, int first,
                     int stride, double slack) const;

    const Eigen::Vector3d& eye(size_t sensor) const { return eyes_[sensor]; }  ///< world

  private:
    const std::vector<CalibratedSensor>* sensors_;
    const Frameset* frameset_;
    std::vector<Eigen::Vector3d> eyes_;
};

}  // namespace deixis
