// Inverse kinematics of the arm for each task.
#include "appliance/simulation/arm_goal.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "appliance/simulation/counter_random.h"
#include "appliance/simulation/floor_track.h"

namespace deixis {
namespace {

using Eigen::Vector3d;

Vector3d level(double facing, const Vector3d& body) {
    return Eigen::AngleAxisd(facing, Vector3d::UnitZ()) * body;
}

/// Slow wander (0.3 to 1.5 Hz, about 1 mm) and physiological tremor (8 to 12 Hz, 0.2 mm) of a raised hand.
Vector3d tremor(uint64_t seed, double time) {
    const CounterRandom random(seed, 41);
    Vector3d sum = Vector3d::Zero();
    for (uint64_t i = 0; i < 12; ++i) {
        const bool slow = i % 4 != 3;
        const double hertz = slow ? random.uniform(3 * i, 0.3, 1.5) : random.uniform(3 * i, 8, 12);
        const double size = slow ? 0.0008 : 0.0003;
        sum[static_cast<int>(i / 4)] +=
            size * std::sin(2 * 3.14159265358979 * (hertz * time + random.uniform(3 * i + 1)));
    }
    return sum;
}

ArmSolution hang(const BodyPose& pose, size_t side, double facing, double swing) {
    const double out = side == 0 ? -1 : 1;
    const Eigen::Matrix3d half =
        Eigen::Quaterniond(pose.chest)
            .slerp(0.75, Eigen::Quaterniond(Eigen::AngleAxisd(facing, Vector3d::UnitZ())))
            .toRotationMatrix();
    const auto direction = [&](double forwards, double sideways) {
        return Vector3d(
            half * Vector3d(out * std::sin(sideways), std::sin(forwards), -std::cos(forwards)).normalized());
    };
    return {{direction(swing - 0.05, 0.16), direction(swing * 1.25 + 0.2, 0.08),
             direction(swing * 1.25 + 0.28, 0.02), 0},
            true};
}

ArmSolution aim(const BodyDimensions& d, const BodyPose& pose, size_t side, const ArmGoal& goal,
                const Vector3d& spot, const ArmSurroundings& around) {
    const Vector3d shoulder = shoulder_of(d, pose, side);
    const Vector3d pole = level(around.facing, {side == 0 ? -0.55 : 0.55, -0.1, -0.8});
    const double beyond = d.hand() + goal.gap;
    if (goal.mode == AimMode::forearm) {
        const TwoBoneDirections r =
            reach_with_two_bones(shoulder, spot, d.upper_arm(), d.forearm() + beyond, pole);
        return {{r.first, r.second, r.second, 1}, r.reached};
    }
    if (goal.mode == AimMode::finger) {
        // Forearm and aimed line make a knee at the wrist: the elbow lies as for one bone of the chord's
        // length.
        const double bend = goal.wrist_bend;
        const double chord = std::sqrt(d.forearm() * d.forearm() + beyond * beyond +
                                       2 * d.forearm() * beyond * std::cos(bend));
        const TwoBoneDirections r = reach_with_two_bones(shoulder, spot, d.upper_arm(), chord, pole);
        const Vector3d elbow = shoulder + d.upper_arm() * r.first;
        const Vector3d end = elbow + chord * r.second;
        const TwoBoneDirections w = reach_with_two_bones(elbow, end, d.forearm(), beyond, Vector3d::UnitZ());
        return {{r.first, w.first, w.second, 1}, r.reached};
    }
    const Vector3d eye = eye_of(d, pose);
    const Vector3d sight = (spot - eye).normalized();
    const Vector3d fingertip = spot - goal.gap * sight;
    Vector3d hand = (fingertip - shoulder).normalized();
    TwoBoneDirections r;
    for (int i = 0; i < 12; ++i) {  // the hand lies halfway between the forearm and the line of sight
        r = reach_with_two_bones(shoulder, fingertip - d.hand() * hand, d.upper_arm(), d.forearm(), pole);
        hand = (r.second + sight).normalized();
    }
    const Vector3d wrist = shoulder + d.upper_arm() * r.first + d.forearm() * r.second;
    hand = (fingertip - wrist).normalized();
    return {{r.first, r.second, hand, 1}, r.reached};
}

ArmSolution to_place(const BodyDimensions& d, const BodyPose& pose, size_t side, const Vector3d& wrist,
                     const Vector3d& hand, const Vector3d& pole) {
    const TwoBoneDirections r =
        reach_with_two_bones(shoulder_of(d, pose, side), wrist, d.upper_arm(), d.forearm(), pole);
    return {{r.first, r.second, hand, 0}, r.reached};
}

}  // namespace

ArmSolution solve_arm(const BodyDimensions& d, const BodyPose& pose, size_t side, const ArmGoal& goal,
                      const ArmSurroundings& around) {
    const double out = side == 0 ? -1 : 1;
    switch (goal.task) {
        case ArmTask::hang:
            break;
        case ArmTask::aim:
            return aim(d, pose, side, goal,
                       around.world_from_part * goal.spot + tremor(goal.tremor_seed, around.time), around);
        case ArmTask::sweep: {
            const double share = (around.time - goal.sweep_from) / (goal.sweep_to - goal.sweep_from);
            const Vector3d spot = goal.spot + std::clamp(share, 0.0, 1.0) * (goal.spot_to - goal.spot);
            return aim(d, pose, side, goal, around.world_from_part * spot, around);
        }
        case ArmTask::grip: {
            const Vector3d grip = around.world_from_trolley * goal.spot;
            const Vector3d towards = level(around.facing, {-0.25 * out, 1, -0.1}).normalized();
            return to_place(d, pose, side, grip - 0.045 * d.height * towards, towards,
                            level(around.facing, {out, -0.2, -0.7}));
        }
        case ArmTask::hip: {
            const Vector3d wrist =
                pose.world_from_pelvis * Vector3d(out * 0.125 * d.height, 0.0, 0.05 * d.height);
            return to_place(d, pose, side, wrist, level(around.facing, {-0.5 * out, 0.8, -0.4}).normalized(),
                            level(around.facing, {out, -0.25, 0}));
        }
        case ArmTask::scratch: {
            const Vector3d rub(0, 0.012 * std::sin(9 * around.time), 0.015 * std::sin(9 * around.time));
            const Vector3d wrist =
                eye_of(d, pose) + pose.head * (Vector3d(out * 0.10, -0.05, -0.01) * d.height / 1.75 + rub);
            return to_place(d, pose, side, wrist, pose.head * Vector3d(-0.6 * out, -0.3, 0.7).normalized(),
                            level(around.facing, {out, 0.5, -0.3}));
        }
    }
    return hang(pose, side, around.facing, around.swing);
}

void ArmTrack::go(double t0, double t1, const ArmGoal& goal) {
    keys_.push_back({t0, t1, goal});
}

ArmPose ArmTrack::at(double t, const BodyDimensions& d, const BodyPose& pose, size_t side,
                     ArmSurroundings around) const {
    around.time = t;
    const auto next = std::find_if(keys_.begin(), keys_.end(), [&](const Key& key) { return t < key.t1; });
    const auto goal_before = [&] { return next == keys_.begin() ? ArmGoal{} : std::prev(next)->goal; };
    if (next == keys_.end() || t <= next->t0) return solve_arm(d, pose, side, goal_before(), around).arm;
    const ArmPose from = solve_arm(d, pose, side, goal_before(), around).arm;
    const ArmPose to = solve_arm(d, pose, side, next->goal, around).arm;
    const double share = minimum_jerk((t - next->t0) / (next->t1 - next->t0));
    // The finger is stretched in the second half of reaching and folds in the first half of letting go.
    const double stretch =
        to.pointing > from.pointing ? minimum_jerk(2 * share - 1) : minimum_jerk(2 * share);
    return {blend_directions(from.upper_arm, to.upper_arm, share),
            blend_directions(from.forearm, to.forearm, share), blend_directions(from.hand, to.hand, share),
            from.pointing + stretch * (to.pointing - from.pointing)};
}

}  // namespace deixis
