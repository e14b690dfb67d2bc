// Tells a part at rest from one that moves, and gives the resting one a steady, averaged pose.
#pragma once

#include <cstdint>
#include <vector>

#include "tracking/geometry/rigid_transform.h"

namespace deixis {

struct RestParams {
    double rest_s = 0.5;      ///< keep still this long [s]
    double rest_m = 0.005;    ///< ... within this [m]: the mean poses of the time's two halves differ by less
                              ///< than half of it, and no pose is off the mean by more than twice it
    double motion_m = 0.006;  ///< farther than this from the resting pose is motion [m]
    int average = 60;         ///< poses in the mean of a resting part, at most
};

/// Distances between poses are felt at the part: shift of its centre plus turn times half its radius [m].
class RestDetector {
  public:
    RestDetector(const Eigen::Vector3d& centre, double radius, RestParams params);

    /// A new pose at `timestamp_us`; `certain` is false when the frame itself shows that the resting pose
    /// explains it as well as the new one (noise, a hand in front): such frames do not end the rest, unless
    /// the poses are twice the motion apart. Two frames in a row end it, a leap of four times the motion does
    /// at once.
    void add(int64_t timestamp_us, const RigidTransform& world_from_part, bool certain);

    void reset();
    bool at_rest() const { return at_rest_; }

    /// The last poses were off the resting one, by motion or by noise: at rest still, but the measured pose
    /// is the better one to show.
    bool leaving() const { return away_ > 0 || off_ > 1; }

    /// The averaged pose; means something only at rest.
    const RigidTransform& resting_pose() const { return resting_; }

    double distance(const RigidTransform& a, const RigidTransform& b) const;

  private:
    struct Sample {
        int64_t timestamp_us;
        RigidTransform pose;
    };
    RigidTransform mean_of_samples(size_t from, size_t to) const;
    void settle(int64_t now_us);

    Eigen::Vector3d centre_;
    double radius_;
    RestParams params_;
    std::vector<Sample> samples_;  ///< oldest first
    bool at_rest_ = false;
    int away_ = 0;  ///< frames in a row that were moved
    int off_ = 0;   ///< frames in a row that were farther off than a resting part
    int averaged_ = 0;
    RigidTransform resting_;
    Eigen::Matrix3d rotation_sum_ = Eigen::Matrix3d::Zero();
    Eigen::Vector3d centre_sum_ = Eigen::Vector3d::Zero();
};

}  // namespace deixis
