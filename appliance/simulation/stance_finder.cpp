// Drawing and checking of stances.
#include "appliance/simulation/stance_finder.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace deixis {

using Eigen::Vector2d;
using Eigen::Vector3d;

double turn_towards(const Vector2d& direction) {
    return std::atan2(-direction.x(), direction.y());
}

StanceFinder::StanceFinder(const Scenario& scenario, const CellScript& script, const SurfaceMesh& part,
                           const RayCaster& part_caster, DrawSequence& draw)
    : scenario_(scenario),
      script_(script),
      caster_(part_caster),
      draw_(draw),
      spots_(part, part_caster, script.trolley_from_part.rotation.transpose() * -Vector3d::UnitY()) {}

std::optional<SkinSpot> StanceFinder::next_spot(const ScenarioAction& action) {
    const auto spot = action.target ? spots_.at(*action.target) : spots_.draw(draw_);
    if (!spot)
        trouble_ = action.target
                       ? "key \"target\" is not a point of the part's outer skin that faces the worker"
                       : "the part has no skin that faces the worker";
    return spot;
}

bool StanceFinder::suits(const SkinSpot& spot, size_t side, bool may_repeat) const {
    const Vector3d right = script_.trolley_from_part.rotation.transpose() * Vector3d::UnitX();
    const double across = (spot.position - spots_.middle()).dot(right) * (side == 1 ? 1 : -1);
    if (across < -0.35 * spots_.half_width()) return false;  // the other arm's side
    return may_repeat ||
           std::none_of(script_.gestures.begin(), script_.gestures.end(), [&](const HeldGesture& g) {
               return g.pointing.target_part && (*g.pointing.target_part - spot.position).norm() < 0.15;
           });
}

std::optional<PointingStance> StanceFinder::find(const ScenarioAction& action, size_t side, double time) {
    for (int attempt = 0; attempt < 600; ++attempt) {
        const auto spot = next_spot(action);
        if (!spot) return std::nullopt;
        if (!action.target && !suits(*spot, side, attempt >= 400)) continue;
        ArmGoal goal = aiming_goal(*spot);
        if (action.touch) goal.gap = 0.002;
        auto stance = draw_stance(*spot, side, goal, time);
        if (!stance) continue;
        scatter(*stance, side, action.touch, time);
        return stance;
    }
    trouble_ = "no stance was found from which the worker's arm reaches the spot";
    return std::nullopt;
}

std::optional<ArmGoal> StanceFinder::reach_from_here(const ScenarioAction& action, size_t side, double lean,
                                                     double time) {
    for (int attempt = 0; attempt < 300; ++attempt) {
        const auto spot = next_spot(action);
        if (!spot) return std::nullopt;
        ArmGoal goal = aiming_goal(*spot);
        goal.gap = draw_.uniform(0.08, 0.25);
        if (solves(goal, script_.worker.feet.at(time).pose, lean, side, time)) return goal;
    }
    trouble_ = "no spot of the part is in reach of the free hand";
    return std::nullopt;
}

ArmGoal StanceFinder::aiming_goal(const SkinSpot& spot) {
    ArmGoal goal{.task = ArmTask::aim, .spot = spot.position, .mode = script_.aim};
    const double share = draw_.uniform(0, 1);  // near the surface more often than far from it
    goal.gap =
        scenario_.worker.gap_min + (scenario_.worker.gap_max - scenario_.worker.gap_min) * share * share;
    goal.wrist_bend = draw_.uniform(0.05, 0.18);
    goal.tremor_seed = static_cast<uint64_t>(draw_.uniform(0, 1e9));
    return goal;
}

std::optional<PointingStance> StanceFinder::draw_stance(const SkinSpot& spot, size_t side,
                                                        const ArmGoal& goal, double time) {
    const BodyDimensions& d = script_.dimensions;
    const RigidTransform world_from_part = script_.surroundings(time).world_from_part;
    const Vector3d target = world_from_part * spot.position, normal = world_from_part.rotation * spot.normal;
    const Vector2d ahead = Eigen::Rotation2Dd(script_.trolley.at(time).pose.turn) * Vector2d::UnitY();
    Vector2d way = ahead - 0.9 * normal.head<2>();
    way = Eigen::Rotation2Dd(draw_.uniform(-0.25, 0.25)) * way.normalized();
    const double inwards = side == 1 ? 1 : -1;
    PointingStance stance{spot, {Vector2d::Zero(), turn_towards(way) + draw_.uniform(-0.12, 0.12)}, 0, goal};
    stance.lean = std::clamp(0.04 + 0.55 * (d.shoulder_height() - target.z() - 0.35), 0.02, 0.5) +
                  draw_.uniform(0, 0.06);
    const Vector3d shoulder =
        shoulder_of(d, stand(d, {stance.feet, Vector2d::Zero(), 0}, stance.lean, 0, time), side);
    const double reach = d.arm_reach() * draw_.uniform(0.92, 0.98) + goal.gap;
    const double drop = shoulder.z() - target.z();
    if (reach < std::abs(drop) + 0.25) return std::nullopt;
    const Vector2d arm = Eigen::Rotation2Dd(inwards * draw_.uniform(-0.1, 0.3)) * way;
    stance.feet.position =
        target.head<2>() - arm * std::sqrt(reach * reach - drop * drop) - shoulder.head<2>();
    if (!free_of_part(stance.feet, time) || !solves(goal, stance.feet, stance.lean, side, time))
        return std::nullopt;
    return stance;
}

bool StanceFinder::free_of_part(const FloorPose& feet, double time) const {
    const Vector2d local = relative_to(script_.trolley.at(time).pose, feet).position;
    const Box& cell = scenario_.cell;
    const Vector2d& p = feet.position;
    return (local.y() < -0.33 || std::abs(local.x()) > 1.3) && p.x() > cell.min.x() + 0.2 &&
           p.x() < cell.max.x() - 0.2 && p.y() > cell.min.y() + 0.2 && p.y() < cell.max.y() - 0.2;
}

/// True when the arm reaches, the aimed line meets the skin first at the spot, and arm and trunk keep clear
/// of it.
bool StanceFinder::solves(const ArmGoal& goal, const FloorPose& feet, double lean, size_t side,
                          double time) const {
    const BodyDimensions& d = script_.dimensions;
    ArmSurroundings around = script_.surroundings(time);
    around.time = time;
    around.facing = feet.turn;
    BodyPose pose = stand(d, {feet, Vector2d::Zero(), 0}, lean, 0, time);
    const Vector3d spot = around.world_from_part * goal.spot;
    look_at(d, pose, spot, 1);
    const ArmSolution solution = solve_arm(d, pose, side, goal, around);
    if (!solution.reached) return false;
    pose.arms[side] = solution.arm;
    const BodyPlaces places = place_body(d, pose);
    const RigidTransform part_from_world = around.world_from_part.inverse();
    const auto hit_distance = [&](const Vector3d& from, const Vector3d& to) {
        const Vector3d a = part_from_world * from, b = part_from_world * to;
        const auto hit = caster_.cast(a.cast<float>(), (b - a).cast<float>(), 0, 1.5F);
        return hit ? hit->distance * (b - a).norm() : 1e9;
    };
    const Vector3d& tip = places.fingertips[side];
    if (std::abs(hit_distance(tip, spot) - (spot - tip).norm()) > 0.02 && goal.gap > 0.01) return false;
    if (hit_distance(places.joints[4 + side], tip) < (tip - places.joints[4 + side]).norm() - 0.02)
        return false;
    const auto clear = [&](const Vector3d& p, double radius) {
        return !caster_.nearest((part_from_world * p).cast<float>(), static_cast<float>(radius));
    };
    return clear(places.joints[8], 0.22) && clear(places.joints[1], 0.2) &&
           clear(places.joints[11 + side], 0.12) && clear(0.5 * (places.joints[1] + places.joints[8]), 0.22);
}

/// Turns the aimed line about its origin (eye, elbow or wrist); a touching finger is guided by sight to a few
/// mm.
void StanceFinder::scatter(PointingStance& stance, size_t side, bool touch, double time) {
    const BodyDimensions& d = script_.dimensions;
    const RigidTransform world_from_part = script_.surroundings(time).world_from_part;
    const Vector3d spot = world_from_part * stance.goal.spot;
    BodyPose pose = stand(d, {stance.feet, Vector2d::Zero(), 0}, stance.lean, 0, time);
    look_at(d, pose, spot, 1);
    const double beyond = d.hand() + stance.goal.gap;
    double length = stance.goal.mode == AimMode::eye       ? (spot - eye_of(d, pose)).norm()
                    : stance.goal.mode == AimMode::forearm ? d.forearm() + beyond
                                                           : beyond;
    if (touch) length = std::min(length, 0.25);
    const Vector3d line = (spot - shoulder_of(d, pose, side)).normalized();
    const Vector3d u = line.unitOrthogonal(), v = line.cross(u);
    const double sigma = scenario_.worker.scatter * length;
    const Vector3d offset = sigma * (draw_.normal() * u + draw_.normal() * v);
    stance.goal.spot += world_from_part.rotation.transpose() * offset;
}

}  // namespace deixis
