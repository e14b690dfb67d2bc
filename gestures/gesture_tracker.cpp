// Limbs, arms, rays, dwell: the list of verbs, and which arm is which.
#include "gestures/gesture_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace deixis {
namespace {

constexpr double kSameArm = 0.35;      // a fingertip this far from the last one may be the same arm's [m]
constexpr float kFarthestPart = 8.0F;  // [m]

std::vector<CalibratedSensor> depth_sensors_of(const SensorRig& rig) {
    std::vector<CalibratedSensor> sensors;
    std::copy_if(rig.sensors.begin(), rig.sensors.end(), std::back_inserter(sensors),
                 [](const CalibratedSensor& s) { return s.kind == SensorKind::depth; });
    return sensors;
}

std::optional<Eigen::Vector3d> horizontal(Eigen::Vector3d v) {
    v.z() = 0;
    if (!(v.norm() > 1e-3)) return std::nullopt;
    return v.normalized();
}

}  // namespace

InvalidSettings GestureTracker::Params::validate() const {
    InvalidSettings complaints = limbs.validate();
    require_range(complaints, "reach_out_m", reach_out_m, 0, 1);
    for (const InvalidSettings& more : {arms.validate(), pointing.validate(), stillness.validate()})
        complaints.insert(complaints.end(), more.begin(), more.end());
    return complaints;
}

GestureTracker::GestureTracker(const SensorRig& rig, const Params& params)
    : params_(params),
      axis_(rig.pointing_axis ? horizontal(*rig.pointing_axis) : std::nullopt),
      limbs_(params.limbs),
      arms_(depth_sensors_of(rig), params.arms),
      tracks_(2, Track(params_.stillness)) {}

GestureOutput GestureTracker::update(const GestureInput& input) {
    follow(input);
    GestureOutput output;
    const bool ready = input.world_from_part && input.part_surface != nullptr && input.part_at_rest;
    double nearest = std::numeric_limits<double>::infinity();
    for (Track& track : tracks_) {
        const auto mark = track.dwell.update(input.timestamp_us, track.ray, ready);
        if (mark && !output.mark) output.mark = mark;
        if (!track.ray) continue;
        const double distance = track.ray->hit ? track.distance : std::numeric_limits<double>::max();
        if (distance >= nearest) continue;
        nearest = distance;
        output.ray = track.ray;
    }
    return output;
}

std::optional<Eigen::Vector3d> GestureTracker::forward_of(const GestureInput& input) const {
    std::optional<Eigen::Vector3d> to_part;
    if (input.part_surface != nullptr && input.world_from_part) {
        const Eigen::Vector3d from = input.worker.middle.cast<double>();
        const auto nearest = input.part_surface->nearest(
            (input.world_from_part->inverse() * from).cast<float>(), kFarthestPart);
        if (nearest) to_part = horizontal(*input.world_from_part * nearest->position.cast<double>() - from);
    }
    if (!to_part) return axis_;
    if (!axis_ || axis_->dot(*to_part) <= 0) return to_part;
    return horizontal(*axis_ + *to_part);
}

void GestureTracker::follow(const GestureInput& input) {
    for (Track& track : tracks_) track.ray.reset();
    const auto forward = forward_of(input);
    if (!input.worker.present || !forward) {
        arms_.clear();
        return;
    }
    const std::vector<ArmCluster>& arms =
        arms_.update(input.worker, input.points, input.part_points, limbs_.update(input.worker), *forward);
    // The closest pair of arm and track first; an arm that is near to none takes a track that rests.
    std::vector<uint8_t> arm_taken(arms.size(), 0);
    std::vector<uint8_t> track_taken(tracks_.size(), 0);
    for (size_t round = 0; round < std::min(arms.size(), tracks_.size()); ++round) {
        double best = std::numeric_limits<double>::infinity();
        size_t best_arm = 0, best_track = 0;
        for (size_t a = 0; a < arms.size(); ++a)
            for (size_t t = 0; t < tracks_.size(); ++t) {
                if (arm_taken[a] || track_taken[t]) continue;
                const auto& last = tracks_[t].last_tip;
                double cost = last ? (arms[a].tip - *last).norm() : kSameArm;
                if (last && cost > kSameArm) cost += kSameArm;
                if (cost >= best) continue;
                best = cost;
                best_arm = a;
                best_track = t;
            }
        arm_taken[best_arm] = track_taken[best_track] = 1;
        tracks_[best_track].last_tip = arms[best_arm].tip;
        aim(input, arms[best_arm], tracks_[best_track]);
    }
}

void GestureTracker::aim(const GestureInput& input, const ArmCluster& arm, Track& track) const {
    PointingRay& ray = track.ray.emplace();
    ray.arm = arm.side;
    ray.origin = arm.tip;
    ray.direction = blend_directions(arm.axis, arm.eye, arm.tip, params_.pointing.eye_weight);
    if (input.part_surface == nullptr || !input.world_from_part) return;
    const auto meant = spot_on_part(*input.part_surface, *input.world_from_part, ray.origin, ray.direction,
                                    params_.pointing);
    if (!meant) return;
    // A hanging hand beside the part aims at it too, but does not reach out to it.
    const Eigen::Vector3d middle = input.worker.middle.cast<double>();
    const auto to_spot = horizontal(*input.world_from_part * meant->spot.position - middle);
    if (!to_spot || (arm.tip - middle).dot(*to_spot) < params_.reach_out_m) return;
    ray.hit = meant->spot;
    ray.touch = meant->touch;
    track.distance = meant->distance_m;
}

}  // namespace deixis
