// Evaluation of the tracks.
#include "appliance/simulation/floor_track.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace deixis {

double minimum_jerk(double share) {
    const double s = std::clamp(share, 0.0, 1.0);
    return s * s * s * (10 + s * (-15 + 6 * s));
}

double wrapped_angle(double angle) {
    return angle - 2 * std::numbers::pi * std::ceil((angle - std::numbers::pi) / (2 * std::numbers::pi));
}

RigidTransform world_from_floor_pose(const FloorPose& pose) {
    return {Eigen::AngleAxisd(pose.turn, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
            {pose.position.x(), pose.position.y(), 0}};
}

FloorPose compose(const FloorPose& outer, const FloorPose& inner) {
    return {outer.position + Eigen::Rotation2Dd(outer.turn) * inner.position,
            wrapped_angle(outer.turn + inner.turn)};
}

FloorPose relative_to(const FloorPose& outer, const FloorPose& pose) {
    return {Eigen::Rotation2Dd(-outer.turn) * (pose.position - outer.position),
            wrapped_angle(pose.turn - outer.turn)};
}

namespace {

FloorPose pose_between(const FloorPose& from, const FloorPose& to, double share) {
    return {from.position + share * (to.position - from.position),
            wrapped_angle(from.turn + share * wrapped_angle(to.turn - from.turn))};
}

double minimum_jerk_slope(double share) {
    const double s = std::clamp(share, 0.0, 1.0);
    return 30 * s * s * (1 - s) * (1 - s);
}

}  // namespace

void FloorTrack::move(double t0, double t1, const FloorPose& to) {
    assert(t1 > t0 && (legs_.empty() || t0 >= legs_.back().t1 - 1e-9));
    const FloorState before = at(t0);
    legs_.push_back({t0, t1, end(), to, before.distance, false, {}, {}});
}

void FloorTrack::ride(double t0, double t1, const FloorTrack& carrier) {
    assert(t1 > t0 && (legs_.empty() || t0 >= legs_.back().t1 - 1e-9));
    const FloorState before = at(t0);
    const FloorPose from = end(), carried_from = carrier.at(t0).pose, carried_to = carrier.at(t1).pose;
    const FloorPose to = compose(carried_to, relative_to(carried_from, from));
    legs_.push_back({t0, t1, from, to, before.distance, true, carried_from, carried_to});
}

FloorState FloorTrack::at(double t) const {
    const auto next = std::find_if(legs_.begin(), legs_.end(), [&](const Leg& leg) { return t < leg.t1; });
    if (next == legs_.end()) {
        if (legs_.empty()) return {start_, Eigen::Vector2d::Zero(), 0};
        const Leg& last = legs_.back();
        return {last.to, Eigen::Vector2d::Zero(),
                last.distance_before + (last.to.position - last.from.position).norm()};
    }
    if (t <= next->t0) return {next->from, Eigen::Vector2d::Zero(), next->distance_before};
    const double raw = (t - next->t0) / (next->t1 - next->t0), share = minimum_jerk(raw);
    const Eigen::Vector2d way = next->to.position - next->from.position;
    FloorState state;
    state.pose = next->rides ? compose(pose_between(next->carrier_from, next->carrier_to, share),
                                       relative_to(next->carrier_from, next->from))
                             : pose_between(next->from, next->to, share);
    state.velocity = way * minimum_jerk_slope(raw) / (next->t1 - next->t0);
    state.distance = next->distance_before + share * way.norm();
    return state;
}

bool FloorTrack::moving(double t) const {
    return std::any_of(legs_.begin(), legs_.end(), [&](const Leg& leg) { return t > leg.t0 && t < leg.t1; });
}

void ScalarTrack::move(double t0, double t1, double to) {
    assert(t1 > t0 && (keys_.empty() || t0 >= keys_.back().t1 - 1e-9));
    keys_.push_back({t0, t1, end(), to});
}

double ScalarTrack::at(double t) const {
    const auto next = std::find_if(keys_.begin(), keys_.end(), [&](const Key& key) { return t < key.t1; });
    if (next == keys_.end()) return end();
    return next->from + minimum_jerk((t - next->t0) / (next->t1 - next->t0)) * (next->to - next->from);
}

}  // namespace deixis
