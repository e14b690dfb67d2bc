// Gait, stance, gaze and arms put together.
#include "appliance/simulation/worker_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace deixis {
namespace {

using Eigen::Vector3d;

/// One foot's offset from its place under the body, as shares: along the way (-0.5 to 0.5 of the stance
/// length), up.
struct FootSwing {
    double along, up;
};

FootSwing foot_swing(double phase) {
    constexpr double stance = 0.6;
    const double p = phase - std::floor(phase);
    if (p < stance) return {0.5 - p / stance, 0};
    const double s = (p - stance) / (1 - stance);
    return {-0.5 + minimum_jerk(s), std::sin(std::numbers::pi * s)};
}

double gait_strength(const FloorState& feet) {
    return std::clamp(feet.velocity.norm() / 0.5, 0.0, 1.0);
}

double gait_phase(const BodyDimensions& d, const FloorState& feet) {
    return feet.distance / (0.72 * d.height);
}

void place_legs(const BodyDimensions& d, const FloorState& feet, BodyPose& pose) {
    const RestJoints rest = rest_joints(d);
    const RigidTransform world_from_feet = world_from_floor_pose(feet.pose);
    const double strength = gait_strength(feet), phase = gait_phase(d, feet);
    const Vector3d way = feet.velocity.norm() > 1e-9
                             ? Vector3d(feet.velocity.x(), feet.velocity.y(), 0).normalized()
                             : Vector3d::Zero();
    for (size_t side = 0; side < 2; ++side) {
        const double out = side == 0 ? -1 : 1;
        const FootSwing swing = foot_swing(phase + 0.5 * static_cast<double>(side));
        const Vector3d place(out * 0.058 * d.height, -0.01 * d.height, d.ankle_height());
        const Vector3d ankle = world_from_feet * place + strength * 0.43 * d.height * swing.along * way +
                               Vector3d(0, 0, strength * 0.05 * d.height * swing.up);
        const Vector3d hip = pose.world_from_pelvis * Vector3d(rest.hip[side] - rest.pelvis);
        const Vector3d forwards = world_from_feet.rotation * Vector3d::UnitY();
        const TwoBoneDirections r =
            reach_with_two_bones(hip, ankle, (rest.knee[side] - rest.hip[side]).norm(),
                                 (rest.ankle[side] - rest.knee[side]).norm(),
                                 forwards + 0.08 * out * (world_from_feet.rotation * Vector3d::UnitX()));
        const double toes =
            strength * 0.3 * (swing.up > 0 ? std::sin(std::numbers::pi * (swing.along + 0.5)) : 0);
        const Vector3d foot =
            world_from_feet.rotation * Vector3d(0.12 * out, std::cos(toes), -std::sin(toes)).normalized();
        pose.legs[side] = {r.first, r.second, foot};
    }
}

}  // namespace

BodyPose stand(const BodyDimensions& d, const FloorState& feet, double lean, double twist, double time) {
    BodyPose pose = rest_pose(d);
    const double strength = gait_strength(feet), phase = 2 * std::numbers::pi * gait_phase(d, feet);
    const double sway_x = 0.004 * std::sin(1.9 * time) + 0.003 * std::sin(3.1 * time + 1);
    const double sway_y = 0.005 * std::sin(1.3 * time + 2) + 0.003 * std::sin(2.3 * time);
    const double bend = lean + 0.05 * strength + 0.004 * std::sin(1.1 * time);
    const auto turn = [&](double about_z, double forwards) {
        return Eigen::Matrix3d(Eigen::AngleAxisd(feet.pose.turn + about_z, Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(-forwards, Vector3d::UnitX()));
    };
    const double rock = 0.10 * strength * std::sin(phase);
    pose.world_from_pelvis.rotation = turn(0.2 * twist + rock, 0.5 * bend);
    pose.chest = turn(twist - rock, bend);
    pose.head = turn(0.5 * twist, 0.4 * bend + 0.08);
    // Leaning moves the hips back so that the weight stays over the feet; walking lowers and bobs them.
    const double height = d.hip_height() - 0.006 * d.height - 0.10 * d.height * lean * lean -
                          strength * d.height * (0.018 - 0.008 * std::cos(2 * phase));
    const Vector3d hips(sway_x, sway_y - 0.16 * d.height * lean, height);
    pose.world_from_pelvis.translation = world_from_floor_pose(feet.pose) * hips;
    place_legs(d, feet, pose);
    return pose;
}

void look_at(const BodyDimensions& d, BodyPose& pose, const Vector3d& spot, double share) {
    const Vector3d ahead = pose.chest * Vector3d::UnitY();
    Vector3d wanted = (spot - eye_of(d, pose)).normalized();
    const double off = std::acos(std::clamp(ahead.dot(wanted), -1.0, 1.0)), most = 1.22;
    if (off > most) wanted = blend_directions(ahead, wanted, most / off);
    const Vector3d now = pose.head * Vector3d::UnitY();
    const Vector3d forwards = blend_directions(now, wanted, share);
    const Vector3d right = forwards.cross(Vector3d::UnitZ()).normalized();
    pose.head.col(0) = right;
    pose.head.col(1) = forwards;
    pose.head.col(2) = right.cross(forwards);
}

BodyPose posture_at(const BodyDimensions& d, const WorkerTracks& tracks, ArmSurroundings around,
                    double time) {
    const FloorState feet = tracks.feet.at(time);
    BodyPose pose = stand(d, feet, tracks.lean.at(time), tracks.twist.at(time), time);
    for (const Gaze& gaze : tracks.gazes) {
        if (time < gaze.t0 || time > gaze.t1) continue;
        const double share =
            std::min(minimum_jerk((time - gaze.t0) / 0.35), minimum_jerk((gaze.t1 - time) / 0.35));
        look_at(d, pose, around.world_from_part * gaze.spot, share);
    }
    around.facing = feet.pose.turn;
    const double swing =
        0.38 * gait_strength(feet) * std::cos(2 * std::numbers::pi * (gait_phase(d, feet) - 0.05));
    for (size_t side = 0; side < 2; ++side) {
        around.swing = side == 0 ? -swing : swing;  // against the leg of the same side
        pose.arms[side] = tracks.arms[side].at(time, d, pose, side, around);
    }
    return pose;
}

}  // namespace deixis
