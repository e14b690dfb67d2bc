// Forward kinematics from limb directions, and the two-bone inverse.
#include "appliance/simulation/body_skeleton.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace deixis {
namespace {

constexpr double arm_rest_angle = 0.78539816339744831;  // 45 degrees out: clear of the trunk for skinning

Eigen::Matrix3d halfway(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
    return Eigen::Quaterniond(a).slerp(0.5, Eigen::Quaterniond(b)).toRotationMatrix();
}

/// Trunk and head of a pose, without limbs.
struct Trunk {
    Eigen::Matrix3d spine, neck;
    Eigen::Vector3d lumbar, chest, neck_base, skull;
};

Trunk place_trunk(const RestJoints& rest, const BodyPose& pose) {
    Trunk t;
    t.spine = halfway(pose.world_from_pelvis.rotation, pose.chest);
    t.neck = halfway(pose.chest, pose.head);
    t.lumbar = pose.world_from_pelvis * Eigen::Vector3d(rest.lumbar - rest.pelvis);
    t.chest = t.lumbar + t.spine * (rest.chest - rest.lumbar);
    t.neck_base = t.chest + pose.chest * (rest.neck - rest.chest);
    t.skull = t.neck_base + t.neck * (rest.skull - rest.neck);
    return t;
}

/// The transform that turns by `rotation` and takes rest point `from` to world point `to`.
RigidTransform about(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& from,
                     const Eigen::Vector3d& to) {
    return {rotation, to - rotation * from};
}

void place_arm(const RestJoints& rest, const BodyPose& pose, const Trunk& trunk, size_t side,
               BodyPlaces& places) {
    const auto bone = [&](BodyBone left) -> RigidTransform& {
        return places.world_from_rest[static_cast<size_t>(of_side(left, side))];
    };
    const ArmPose& arm = pose.arms[side];
    const Eigen::Vector3d& axis = rest.arm_axis[side];
    const Eigen::Vector3d shoulder = trunk.chest + pose.chest * (rest.shoulder[side] - rest.chest);
    const Eigen::Vector3d elbow = shoulder + (rest.elbow[side] - rest.shoulder[side]).norm() * arm.upper_arm;
    const Eigen::Vector3d wrist = elbow + (rest.wrist[side] - rest.elbow[side]).norm() * arm.forearm;

    const Eigen::Matrix3d upper = swing_between(pose.chest * axis, arm.upper_arm) * pose.chest;
    const Eigen::Matrix3d fore = swing_between(upper * axis, arm.forearm) * upper;
    const Eigen::Matrix3d hand = swing_between(fore * axis, arm.hand) * fore;
    bone(BodyBone::left_upper_arm) = about(upper, rest.shoulder[side], shoulder);
    bone(BodyBone::left_forearm) = about(fore, rest.elbow[side], elbow);
    bone(BodyBone::left_hand) = about(hand, rest.wrist[side], wrist);

    // The finger folds towards the palm, which faces inwards and down at rest.
    const double fold = 1.0 - arm.pointing;
    const Eigen::Vector3d hinge = (side == 0 ? 1.0 : -1.0) * Eigen::Vector3d::UnitY();
    const Eigen::Matrix3d first = hand * Eigen::AngleAxisd(-1.45 * fold, hinge).toRotationMatrix();
    const Eigen::Matrix3d second = first * Eigen::AngleAxisd(-1.6 * fold, hinge).toRotationMatrix();
    const Eigen::Vector3d knuckle = bone(BodyBone::left_hand) * rest.knuckle[side];
    bone(BodyBone::left_finger) = about(first, rest.knuckle[side], knuckle);
    bone(BodyBone::left_fingertip) =
        about(second, rest.finger_joint[side], bone(BodyBone::left_finger) * rest.finger_joint[side]);

    places.joints[2 + side] = shoulder;
    places.joints[4 + side] = elbow;
    places.joints[6 + side] = wrist;
    places.fingertips[side] = wrist + (rest.fingertip[side] - rest.wrist[side]).norm() * arm.hand;
}

void place_leg(const RestJoints& rest, const BodyPose& pose, size_t side, BodyPlaces& places) {
    const auto bone = [&](BodyBone left) -> RigidTransform& {
        return places.world_from_rest[static_cast<size_t>(of_side(left, side))];
    };
    const LegPose& leg = pose.legs[side];
    const Eigen::Matrix3d& pelvis = pose.world_from_pelvis.rotation;
    const Eigen::Vector3d hip = pose.world_from_pelvis * Eigen::Vector3d(rest.hip[side] - rest.pelvis);
    const Eigen::Vector3d down = (rest.knee[side] - rest.hip[side]).normalized();
    const Eigen::Vector3d down_shank = (rest.ankle[side] - rest.knee[side]).normalized();
    const Eigen::Vector3d knee = hip + (rest.knee[side] - rest.hip[side]).norm() * leg.thigh;
    const Eigen::Vector3d ankle = knee + (rest.ankle[side] - rest.knee[side]).norm() * leg.shank;

    const Eigen::Matrix3d thigh = swing_between(pelvis * down, leg.thigh) * pelvis;
    const Eigen::Matrix3d shank = swing_between(thigh * down_shank, leg.shank) * thigh;
    const Eigen::Matrix3d foot = swing_between(shank * Eigen::Vector3d::UnitY(), leg.foot) * shank;
    bone(BodyBone::left_thigh) = about(thigh, rest.hip[side], hip);
    bone(BodyBone::left_shank) = about(shank, rest.knee[side], knee);
    bone(BodyBone::left_foot) = about(foot, rest.ankle[side], ankle);
    places.joints[9 + side] = hip;
    places.joints[11 + side] = knee;
    places.joints[13 + side] = ankle;
}

}  // namespace

Eigen::Matrix3d swing_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

Eigen::Vector3d blend_directions(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double share) {
    const double angle = std::acos(std::clamp(from.dot(to), -1.0, 1.0));
    if (angle < 1e-6) return to;
    Eigen::Vector3d axis = from.cross(to);
    if (axis.norm() < 1e-9) axis = from.unitOrthogonal();
    return Eigen::AngleAxisd(angle * share, axis.normalized()) * from;
}

TwoBoneDirections reach_with_two_bones(const Eigen::Vector3d& root, const Eigen::Vector3d& end, double a,
                                       double b, const Eigen::Vector3d& pole) {
    const Eigen::Vector3d way = end - root;
    const double asked = way.norm();
    const double distance = std::clamp(asked, std::abs(a - b) * 1.02 + 1e-3, (a + b) * 0.9995);
    const Eigen::Vector3d along = asked > 1e-9 ? Eigen::Vector3d(way / asked) : Eigen::Vector3d(-pole);
    Eigen::Vector3d sideways = pole - along * along.dot(pole);
    if (sideways.norm() < 1e-6) sideways = along.unitOrthogonal();
    sideways.normalize();
    const double forwards = (a * a - b * b + distance * distance) / (2 * distance);
    const double height = std::sqrt(std::max(0.0, a * a - forwards * forwards));
    const Eigen::Vector3d joint = forwards * along + height * sideways;
    return {joint.normalized(), (distance * along - joint).normalized(), std::abs(distance - asked) < 1e-9};
}

RestJoints rest_joints(const BodyDimensions& d) {
    const double h = d.height;
    RestJoints r;
    r.pelvis = {0, 0, d.hip_height()};
    r.lumbar = {0, -0.012 * h, 0.580 * h};
    r.chest = {0, -0.012 * h, 0.660 * h};
    r.neck = {0, -0.014 * h, 0.848 * h};
    r.skull = {0, 0.002 * h, 0.885 * h};
    r.head_top = {0, 0.006 * h, h};
    r.eye = {0, 0.060 * h, 0.936 * h};
    for (size_t side = 0; side < 2; ++side) {
        const double sign = side == 0 ? -1 : 1;
        const Eigen::Vector3d axis(sign * std::sin(arm_rest_angle), 0, -std::cos(arm_rest_angle));
        r.arm_axis[side] = axis;
        r.shoulder[side] = {sign * d.shoulder_half(), 0, d.shoulder_height()};
        r.elbow[side] = r.shoulder[side] + d.upper_arm() * axis;
        r.wrist[side] = r.elbow[side] + d.forearm() * axis;
        r.knuckle[side] = r.wrist[side] + 0.052 * h * axis;
        r.finger_joint[side] = r.wrist[side] + 0.075 * h * axis;
        r.fingertip[side] = r.wrist[side] + d.hand() * axis;
        r.hip[side] = {sign * d.hip_half(), 0, d.hip_height()};
        r.knee[side] = {sign * d.hip_half(), 0.004 * h, d.hip_height() - d.thigh()};
        r.ankle[side] = {sign * d.hip_half(), -0.008 * h, d.ankle_height()};
    }
    return r;
}

BodyPose rest_pose(const BodyDimensions& dimensions) {
    const RestJoints rest = rest_joints(dimensions);
    BodyPose pose;
    pose.world_from_pelvis.translation = rest.pelvis;
    for (size_t side = 0; side < 2; ++side) {
        pose.arms[side] = {rest.arm_axis[side], rest.arm_axis[side], rest.arm_axis[side], 1.0};
        pose.legs[side] = {(rest.knee[side] - rest.hip[side]).normalized(),
                           (rest.ankle[side] - rest.knee[side]).normalized(), Eigen::Vector3d::UnitY()};
    }
    return pose;
}

BodyPlaces place_body(const BodyDimensions& dimensions, const BodyPose& pose) {
    const RestJoints rest = rest_joints(dimensions);
    const Trunk trunk = place_trunk(rest, pose);
    BodyPlaces places;
    const auto bone = [&](BodyBone b) -> RigidTransform& {
        return places.world_from_rest[static_cast<size_t>(b)];
    };
    bone(BodyBone::pelvis) =
        about(pose.world_from_pelvis.rotation, rest.pelvis, pose.world_from_pelvis.translation);
    bone(BodyBone::spine) = about(trunk.spine, rest.lumbar, trunk.lumbar);
    bone(BodyBone::chest) = about(pose.chest, rest.chest, trunk.chest);
    bone(BodyBone::neck) = about(trunk.neck, rest.neck, trunk.neck_base);
    bone(BodyBone::head) = about(pose.head, rest.skull, trunk.skull);
    places.joints[0] = bone(BodyBone::head) * rest.head_top;
    places.joints[1] = trunk.neck_base;
    places.joints[8] = pose.world_from_pelvis.translation;
    places.eye = bone(BodyBone::head) * rest.eye;
    for (size_t side = 0; side < 2; ++side) {
        place_arm(rest, pose, trunk, side, places);
        place_leg(rest, pose, side, places);
    }
    return places;
}

Eigen::Vector3d shoulder_of(const BodyDimensions& dimensions, const BodyPose& pose, size_t side) {
    const RestJoints rest = rest_joints(dimensions);
    return place_trunk(rest, pose).chest + pose.chest * (rest.shoulder[side] - rest.chest);
}

Eigen::Vector3d eye_of(const BodyDimensions& dimensions, const BodyPose& pose) {
    const RestJoints rest = rest_joints(dimensions);
    return place_trunk(rest, pose).skull + pose.head * (rest.eye - rest.skull);
}

}  // namespace deixis
