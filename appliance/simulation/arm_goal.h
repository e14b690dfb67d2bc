// What one arm is up to, and the posture that does it: hanging, aiming, sweeping past, gripping, at hip or
// head.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "appliance/simulation/body_skeleton.h"
#include "appliance/simulation/scenario.h"

namespace deixis {

enum class ArmTask { hang, aim, sweep, grip, hip, scratch };

struct ArmGoal {
    ArmTask task = ArmTask::hang;
    Eigen::Vector3d spot = Eigen::Vector3d::Zero();     ///< aim, sweep: part frame; grip: trolley frame [m]
    Eigen::Vector3d spot_to = Eigen::Vector3d::Zero();  ///< sweep: where it ends
    double sweep_from = 0, sweep_to = 0;                ///< sweep: when [s]
    AimMode mode = AimMode::forearm;
    double gap = 0.1;       ///< fingertip to spot along the aimed line [m]
    double wrist_bend = 0;  ///< finger: angle between forearm and aimed line [rad]
    uint64_t tremor_seed = 0;
};

/// What a goal is solved against; world frame.
struct ArmSurroundings {
    RigidTransform world_from_part;
    RigidTransform world_from_trolley;
    double time = 0;    ///< [s]
    double facing = 0;  ///< turn of the worker about Z, 0 = along +y [rad]
    double swing = 0;   ///< of the hanging arm, forwards positive [rad]
};

struct ArmSolution {
    ArmPose arm;
    bool reached = true;  ///< false: too far or too near, the arm does what it can
};

/// The arm of `side` for trunk and head of `pose`. Aiming (see AimMode) puts exactly on one line: eye,
/// fingertip, spot; or elbow, wrist, fingertip, spot; or wrist, fingertip, spot. The fingertip trembles by
/// about a millimetre.
ArmSolution solve_arm(const BodyDimensions& dimensions, const BodyPose& pose, size_t side,
                      const ArmGoal& goal, const ArmSurroundings& around);

/// Goals of one arm in time: from `t0` to `t1` the arm goes over to `goal` and stays at it.
class ArmTrack {
  public:
    void go(double t0, double t1, const ArmGoal& goal);
    ArmPose at(double t, const BodyDimensions& dimensions, const BodyPose& pose, size_t side,
               ArmSurroundings around) const;
    double end() const { return keys_.empty() ? 0 : keys_.back().t1; }

  private:
    struct Key {
        double t0, t1;
        ArmGoal goal;
    };
    std::vector<Key> keys_;
};

}  // namespace deixis
