// A captured motion played by our own body: limb directions from the clip, lengths from the body.
#pragma once

#include "appliance/simulation/body_skeleton.h"
#include "appliance/simulation/motion_clip.h"
#include "appliance/simulation/scenario.h"

namespace deixis {

class ClipMotion {
  public:
    /// The first frame stands at `start`, facing as it says. Ways on the floor are scaled by `scale` metres
    /// per unit, 0: by the length of our legs over the clip's. The lower ankle is as high as the clip's above
    /// its lowest one.
    ClipMotion(const BodyDimensions& dimensions, MotionClip clip, const FloorPose& start, double scale);

    double duration_s() const;

    /// Between frames the joints are interpolated along straight lines; before the first and after the last
    /// they stay.
    BodyPose at(double time) const;

  private:
    BodyDimensions dimensions_;
    MotionClip clip_;
    double scale_ = 1;
    double floor_ = 0;  ///< lowest ankle of the clip
    Eigen::Matrix3d world_from_clip_;
    Eigen::Vector3d origin_;  ///< of the clip: under its first pelvis
    Eigen::Vector3d start_;
};

}  // namespace deixis
