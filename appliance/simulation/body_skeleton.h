// The worker's skeleton: dimensions from height and build, a pose as directions of the limbs, where the bones
// are then.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "tracking/geometry/rigid_transform.h"

namespace deixis {

/// Body frame at rest: x to the worker's right, y forwards, z up, origin on the floor between the feet. Arms
/// hang 45 degrees out. Index 0 is left, 1 is right, everywhere.
enum class BodyBone {
    pelvis,
    spine,
    chest,
    neck,
    head,
    left_upper_arm,
    left_forearm,
    left_hand,
    left_finger,
    left_fingertip,
    left_thigh,
    left_shank,
    left_foot,
    right_upper_arm,
    right_forearm,
    right_hand,
    right_finger,
    right_fingertip,
    right_thigh,
    right_shank,
    right_foot
};
inline constexpr size_t body_bone_count = 21;

/// Bone of one side: `of_side(BodyBone::left_hand, 1)` is the right hand.
inline BodyBone of_side(BodyBone left, size_t side) {
    return static_cast<BodyBone>(static_cast<size_t>(left) + 8 * side);
}

/// Segment lengths as shares of body height by Drillis and Contini (1966), joint centres of the shoulder and
/// hip inside the breadths they give.
struct BodyDimensions {
    double height = 1.75;  ///< [m]
    double girth = 1.0;    ///< factor on all radii

    double upper_arm() const { return 0.186 * height; }
    double forearm() const { return 0.146 * height; }
    double hand() const { return 0.098 * height; }  ///< wrist to the tip of the stretched index finger
    double thigh() const { return 0.245 * height; }
    double shank() const { return 0.246 * height; }
    double arm_reach() const { return upper_arm() + forearm() + hand(); }
    double hip_height() const { return 0.530 * height; }
    double ankle_height() const { return 0.039 * height; }
    double shoulder_height() const { return 0.818 * height; }
    double shoulder_half() const { return 0.108 * height; }
    double hip_half() const { return 0.055 * height; }
};

struct ArmPose {
    Eigen::Vector3d upper_arm, forearm, hand;  ///< unit, world frame, away from the shoulder
    double pointing = 0;                       ///< 0 = fist, 1 = index finger stretched in line with the hand
};

struct LegPose {
    Eigen::Vector3d thigh, shank, foot;  ///< unit, world frame; the foot's points to the toes
};

/// A whole posture, world frame.
struct BodyPose {
    RigidTransform world_from_pelvis;
    Eigen::Matrix3d chest = Eigen::Matrix3d::Identity();  ///< world_from_chest, rotation
    Eigen::Matrix3d head = Eigen::Matrix3d::Identity();   ///< world_from_head, rotation
    std::array<ArmPose, 2> arms;
    std::array<LegPose, 2> legs;
};

/// World places of a pose.
struct BodyPlaces {
    std::array<RigidTransform, body_bone_count> world_from_rest;  ///< moves a rest point of that bone
    std::array<Eigen::Vector3d, 15> joints;                       ///< order of formats.md
    std::array<Eigen::Vector3d, 2> fingertips;                    ///< of the stretched finger
    Eigen::Vector3d eye;                                          ///< between the eyes
};

/// Joints of the rest posture, body frame.
struct RestJoints {
    Eigen::Vector3d pelvis, lumbar, chest, neck, skull, head_top, eye;
    std::array<Eigen::Vector3d, 2> shoulder, elbow, wrist, knuckle, finger_joint, fingertip, hip, knee, ankle;
    std::array<Eigen::Vector3d, 2> arm_axis;  ///< unit, shoulder to fingertip
};

RestJoints rest_joints(const BodyDimensions& dimensions);

/// Arms hanging 45 degrees out, facing +y, feet on the floor at the origin.
BodyPose rest_pose(const BodyDimensions& dimensions);

BodyPlaces place_body(const BodyDimensions& dimensions, const BodyPose& pose);

/// Shoulder joint of `side` for pelvis and chest of `pose`, world frame; the arms do not matter.
Eigen::Vector3d shoulder_of(const BodyDimensions& dimensions, const BodyPose& pose, size_t side);

/// Eye of `pose`; arms and legs do not matter.
Eigen::Vector3d eye_of(const BodyDimensions& dimensions, const BodyPose& pose);

/// Directions of two bones of lengths a and b from `root` so that they end at `end`, the joint between them
/// towards `pole`; an end that is too far or too near is moved along the line to it until it fits.
struct TwoBoneDirections {
    Eigen::Vector3d first, second;
    bool reached = true;
};
TwoBoneDirections reach_with_two_bones(const Eigen::Vector3d& root, const Eigen::Vector3d& end, double a,
                                       double b, const Eigen::Vector3d& pole);

/// The least rotation that takes unit vector `from` to unit vector `to`.
Eigen::Matrix3d swing_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Between unit vectors, share in [0, 1], along the great circle.
Eigen::Vector3d blend_directions(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double share);

}  // namespace deixis
