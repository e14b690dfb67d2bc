// Retargeting by directions.
#include "appliance/simulation/clip_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace deixis {
namespace {

using Eigen::Vector3d;

Vector3d direction(const Vector3d& from, const Vector3d& to, const Vector3d& otherwise) {
    const Vector3d way = to - from;
    return way.norm() > 1e-6 ? Vector3d(way.normalized()) : otherwise;
}

/// Axes with x along `right` as far as `up` allows.
Eigen::Matrix3d axes_of(const Vector3d& right, const Vector3d& up) {
    Eigen::Matrix3d m;
    m.col(2) = up.normalized();
    Vector3d forwards = m.col(2).cross(right);
    if (forwards.norm() < 1e-9) forwards = m.col(2).unitOrthogonal();
    m.col(1) = forwards.normalized();
    m.col(0) = m.col(1).cross(m.col(2));
    return m;
}

double leg_length(const ClipFrame& f) {
    return (f.joints[9] - f.joints[11]).norm() + (f.joints[11] - f.joints[13]).norm();
}

ClipFrame frame_between(const ClipFrame& a, const ClipFrame& b, double share) {
    ClipFrame f = a;
    for (size_t i = 0; i < f.joints.size(); ++i) f.joints[i] += share * (b.joints[i] - a.joints[i]);
    for (size_t i = 0; i < 2; ++i) {
        f.toes[i] += share * (b.toes[i] - a.toes[i]);
        f.hand_ends[i] += share * (b.hand_ends[i] - a.hand_ends[i]);
    }
    return f;
}

}  // namespace

ClipMotion::ClipMotion(const BodyDimensions& dimensions, MotionClip clip, const FloorPose& start,
                       double scale)
    : dimensions_(dimensions), clip_(std::move(clip)) {
    const ClipFrame& first = clip_.frames.front();
    scale_ =
        scale > 0 ? scale : (dimensions.thigh() + dimensions.shank()) / std::max(leg_length(first), 1e-6);
    floor_ = std::numeric_limits<double>::infinity();
    for (const ClipFrame& f : clip_.frames) floor_ = std::min({floor_, f.joints[13].z(), f.joints[14].z()});
    const Vector3d right = first.joints[10] - first.joints[9];
    const double faces =
        std::atan2(right.y(), right.x());  // turn of someone whose right hand points along `right`
    world_from_clip_ = Eigen::AngleAxisd(start.turn - faces, Vector3d::UnitZ()).toRotationMatrix();
    origin_ = {first.joints[8].x(), first.joints[8].y(), 0};
    start_ = {start.position.x(), start.position.y(), 0};
}

double ClipMotion::duration_s() const {
    return clip_.seconds_per_frame * static_cast<double>(clip_.frames.size() - 1);
}

BodyPose ClipMotion::at(double time) const {
    const double place =
        std::clamp(time / clip_.seconds_per_frame, 0.0, static_cast<double>(clip_.frames.size() - 1));
    const auto before = static_cast<size_t>(place);
    const size_t after = std::min(before + 1, clip_.frames.size() - 1);
    ClipFrame f =
        frame_between(clip_.frames[before], clip_.frames[after], place - static_cast<double>(before));
    for (Vector3d& p : f.joints) p = world_from_clip_ * p;
    for (Vector3d& p : f.toes) p = world_from_clip_ * p;
    for (Vector3d& p : f.hand_ends) p = world_from_clip_ * p;

    BodyPose pose = rest_pose(dimensions_);
    const auto& j = f.joints;
    const Vector3d shoulders = 0.5 * (j[2] + j[3]);
    const Vector3d up = direction(j[8], 0.5 * (shoulders + j[1]), Vector3d::UnitZ());
    pose.world_from_pelvis.rotation = axes_of(j[10] - j[9], up);
    pose.chest = axes_of(j[3] - j[2], up);
    // The line from neck to crown leans forwards in a head held upright: take that lean out again.
    const RestJoints rest = rest_joints(dimensions_);
    const Vector3d crown = rest.head_top - rest.neck;
    const double lean = std::atan2(crown.y(), crown.z());
    pose.head = axes_of(pose.chest.col(0), direction(j[1], j[0], up)) *
                Eigen::AngleAxisd(lean, Vector3d::UnitX()).toRotationMatrix();
    for (size_t side = 0; side < 2; ++side) {
        ArmPose& arm = pose.arms[side];
        arm.upper_arm = direction(j[2 + side], j[4 + side], -Vector3d::UnitZ());
        arm.forearm = direction(j[4 + side], j[6 + side], arm.upper_arm);
        arm.hand = direction(j[6 + side], f.hand_ends[side], arm.forearm);
        if (arm.hand.dot(arm.forearm) < 0.2) arm.hand = arm.forearm;  // a thumb or a marker, no hand
        arm.pointing = 0;
        LegPose& leg = pose.legs[side];
        leg.thigh = direction(j[9 + side], j[11 + side], -Vector3d::UnitZ());
        leg.shank = direction(j[11 + side], j[13 + side], leg.thigh);
        leg.foot = direction(j[13 + side], f.toes[side], pose.world_from_pelvis.rotation.col(1));
    }
    const Vector3d moved = scale_ * (j[8] - world_from_clip_ * origin_);
    pose.world_from_pelvis.translation = start_ + Vector3d(moved.x(), moved.y(), dimensions_.hip_height());
    const BodyPlaces places = place_body(dimensions_, pose);
    const double lowest = std::min(places.joints[13].z(), places.joints[14].z());
    const double wanted = dimensions_.ankle_height() + scale_ * (std::min(j[13].z(), j[14].z()) - floor_);
    pose.world_from_pelvis.translation.z() += wanted - lowest;
    return pose;
}

}  // namespace deixis
