// Actions become tracks, one function a kind of action.
#include "appliance/simulation/script_planner.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "appliance/simulation/cell_scenery.h"
#include "appliance/simulation/counter_random.h"
#include "appliance/simulation/skin_spots.h"

namespace deixis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Turn of a worker who looks along `direction`.
double turn_towards(const Vector2d& direction) {
    return std::atan2(-direction.x(), direction.y());
}

struct Stance {
    FloorPose feet;
    double lean = 0;
    ArmGoal goal;
};

class Planner {
  public:
    Planner(const Scenario& scenario, uint64_t seed, const SurfaceMesh& part, const RayCaster& caster,
            CellScript script)
        : scenario_(scenario),
          draw_(seed, 7),
          caster_(caster),
          spots_(part, caster, script.trolley_from_part.rotation.transpose() * -Vector3d::UnitY()),
          script_(std::move(script)),
          left_next_(draw_.coin()) {}

    Result<CellScript> run() {
        for (size_t i = 0; i < scenario_.actions.size(); ++i) {
            const ScenarioAction& action = scenario_.actions[i];
            if (!perform(action))
                return fail(scenario_.file.string() + ": action " + std::to_string(i + 1) +
                            " cannot be played: " + trouble_);
        }
        script_.duration = now_ + scenario_.tail;
        return std::move(script_);
    }

  private:
    bool perform(const ScenarioAction& action) {
        switch (action.kind) {
            case ActionKind::wait:
                now_ += action.seconds.value_or(1.0);
                return true;
            case ActionKind::walk:
                walk(action.to);
                return true;
            case ActionKind::push:
                return action.by_end ? push_by_end(action) : push_by_corner(action);
            case ActionKind::point:
                return point(action);
            case ActionKind::pass:
                return pass(action);
            case ActionKind::hip:
                return hand_at_hip(action);
            case ActionKind::scratch:
                return scratch(action);
            case ActionKind::lean:
                return lean_over(action);
        }
        return false;
    }

    FloorPose trolley() const { return script_.trolley.end(); }

    // --- feet ---

    void leg(const FloorPose& to, double seconds) {
        script_.worker.feet.move(now_, now_ + seconds, to);
        now_ += seconds;
    }

    void walk_straight(const FloorPose& to) {
        const FloorPose from = script_.worker.feet.end();
        const Vector2d way = to.position - from.position;
        const double turn = std::abs(wrapped_angle(to.turn - from.turn));
        if (way.norm() < 0.015 && turn < 0.03) return;
        if (way.norm() < 0.75 && turn < 0.9) {  // a step or two aside, eyes on the part
            leg(to, std::max({0.5, way.norm() / 0.55, turn / 1.3}));
            return;
        }
        const double heading = turn_towards(way);
        const auto turn_to = [&](double angle) {
            const FloorPose here = script_.worker.feet.end();
            const double by = std::abs(wrapped_angle(angle - here.turn));
            if (by > 0.1) leg({here.position, angle}, std::max(0.35, by / 2.4));
        };
        if (way.norm() >= 0.1) {
            turn_to(heading);
            leg({to.position, script_.worker.feet.end().turn}, std::max(0.6, way.norm() / 0.9));
        }
        turn_to(to.turn);
        leg(to, 0.1);
    }

    /// Around the trolley's front corners, never through it.
    void walk(const FloorPose& to) {
        const auto beside = [&](const Vector2d& p) { return p.y() > -0.32; };
        const Vector2d from_local = relative_to(trolley(), script_.worker.feet.end()).position;
        const Vector2d to_local = relative_to(trolley(), to).position;
        const auto corner = [&](const Vector2d& p) {
            const FloorPose at{{p.x() < 0 ? -1.38 : 1.38, -0.55}, 0};
            FloorPose world = compose(trolley(), at);
            world.turn = script_.worker.feet.end().turn;
            return world;
        };
        const bool same_side = beside(from_local) && beside(to_local) && from_local.x() * to_local.x() > 0;
        if (scenario_.part.present && !same_side && (to_local - from_local).norm() > 0.4) {
            if (beside(from_local)) walk_past(corner(from_local));
            if (beside(to_local)) walk_past(corner(to_local));
        }
        walk_straight(to);
    }

    void walk_past(const FloorPose& corner) {
        const Vector2d way = corner.position - script_.worker.feet.end().position;
        walk_straight({corner.position, way.norm() > 0.1 ? turn_towards(way) : corner.turn});
    }

    // --- trolley ---

    double push_seconds(const ScenarioAction& action) {
        const double way = (action.to.position - trolley().position).norm();
        const double turn = std::abs(wrapped_angle(action.to.turn - trolley().turn));
        return action.seconds.value_or(std::max({2.6, way / 0.75, turn / 0.35}));
    }

    bool push_by_end(const ScenarioAction& action) {
        const Vector2d way = relative_to(trolley(), action.to).position;
        const double end = way.x() >= 0 ? -1 : 1;
        walk(compose(trolley(), end_stance(end)));
        const TrolleyGrips grips;
        for (size_t side = 0; side < 2; ++side) {
            // Facing +x the worker's left hand is on the far (+y) end of the bar, facing -x on the near one.
            Vector3d grip = (end < 0) == (side == 0) ? grips.end_right : grips.end_left;
            if (end > 0) grip.x() = -grip.x();
            script_.worker.arms[side].go(now_, now_ + 0.6, {.task = ArmTask::grip, .spot = grip});
        }
        script_.worker.lean.move(now_, now_ + 0.6, 0.10);
        now_ += 0.6;
        const double seconds = push_seconds(action);
        script_.trolley.move(now_, now_ + seconds, action.to);
        script_.worker.feet.ride(now_, now_ + seconds, script_.trolley);
        now_ += seconds + 0.1;
        for (ArmTrack& arm : script_.worker.arms) arm.go(now_, now_ + 0.5, {});
        now_ += 0.5;
        return true;
    }

    bool push_by_corner(const ScenarioAction& action) {
        const double end = action.left_arm ? (*action.left_arm ? -1 : 1) : (draw_.coin() ? -1 : 1);
        const size_t gripping = end < 0 ? 0 : 1, free = 1 - gripping;
        walk(compose(trolley(), {{end * 0.70, -0.42}, 0}));
        TrolleyGrips grips;
        if (end > 0) grips.corner.x() = -grips.corner.x();
        const double lean = std::clamp(script_.worker.lean.end(), 0.10, 0.25);
        script_.worker.lean.move(now_, now_ + 0.6, lean);
        script_.worker.arms[gripping].go(now_, now_ + 0.6, {.task = ArmTask::grip, .spot = grips.corner});
        now_ += 0.6;
        const double seconds = std::max(push_seconds(action), action.pointing ? 3.6 : 0.0), start = now_;
        script_.trolley.move(now_, now_ + seconds, action.to);
        script_.worker.feet.ride(now_, now_ + seconds, script_.trolley);
        if (action.pointing) {
            // Only in the middle of the way, where nobody would call the part at rest.
            const double t0 = start + 0.25 * seconds, t1 = start + 0.72 * seconds;
            const auto goal = reachable_from_here(action, free, lean, 0.5 * (t0 + t1));
            if (!goal) return trouble("no spot of the part is in reach of the free hand");
            script_.worker.arms[free].go(t0 - 0.75, t0, *goal);
            script_.worker.arms[free].go(t1, t1 + 0.5, {});
            script_.worker.gazes.push_back({t0 - 0.75, t1 + 0.3, goal->spot});
            hold(t0, t1, free, false, false, goal->spot);
        }
        now_ = start + seconds + 0.1;
        script_.worker.arms[gripping].go(now_, now_ + 0.5, {});
        now_ += 0.5;
        return true;
    }

    std::optional<ArmGoal> reachable_from_here(const ScenarioAction& action, size_t side, double lean,
                                               double time) {
        for (int attempt = 0; attempt < 300; ++attempt) {
            const auto spot = action.target ? spots_.at(*action.target) : spots_.draw(draw_);
            if (!spot) return std::nullopt;
            ArmGoal goal = aiming_goal(*spot);
            goal.gap = draw_.uniform(0.08, 0.25);
            if (solves(goal, script_.worker.feet.at(time).pose, lean, side, time)) return goal;
        }
        return std::nullopt;
    }

    // --- pointing ---

    ArmGoal aiming_goal(const SkinSpot& spot) {
        ArmGoal goal{.task = ArmTask::aim, .spot = spot.position, .mode = script_.aim};
        const double share = draw_.uniform(0, 1);  // near the surface more often than far from it
        goal.gap =
            scenario_.worker.gap_min + (scenario_.worker.gap_max - scenario_.worker.gap_min) * share * share;
        goal.wrist_bend = draw_.uniform(0.05, 0.18);
        goal.tremor_seed = static_cast<uint64_t>(draw_.uniform(0, 1e9));
        return goal;
    }

    /// A place to stand from which `side`'s stretched arm aims at `spot`; nothing when this draw does not
    /// fit.
    std::optional<Stance> draw_stance(const SkinSpot& spot, size_t side, const ArmGoal& goal) {
        const BodyDimensions& d = script_.dimensions;
        const RigidTransform world_from_part = script_.surroundings(now_).world_from_part;
        const Vector3d target = world_from_part * spot.position,
                       normal = world_from_part.rotation * spot.normal;
        const Vector2d ahead = Eigen::Rotation2Dd(trolley().turn) * Vector2d::UnitY();
        Vector2d way = ahead - 0.9 * normal.head<2>();
        way = Eigen::Rotation2Dd(draw_.uniform(-0.25, 0.25)) * way.normalized();
        const double inwards = side == 1 ? 1 : -1;
        Stance stance{{Vector2d::Zero(), turn_towards(way) + draw_.uniform(-0.12, 0.12)}, 0, goal};
        stance.lean = std::clamp(0.04 + 0.55 * (d.shoulder_height() - target.z() - 0.35), 0.02, 0.5) +
                      draw_.uniform(0, 0.06);
        const Vector3d shoulder =
            shoulder_of(d, stand(d, {stance.feet, Vector2d::Zero(), 0}, stance.lean, 0, now_), side);
        const double reach = d.arm_reach() * draw_.uniform(0.92, 0.98) + goal.gap;
        const double drop = shoulder.z() - target.z();
        if (reach < std::abs(drop) + 0.25) return std::nullopt;
        const Vector2d arm = Eigen::Rotation2Dd(inwards * draw_.uniform(-0.1, 0.3)) * way;
        stance.feet.position =
            target.head<2>() - arm * std::sqrt(reach * reach - drop * drop) - shoulder.head<2>();
        if (!free_of_part(stance) || !solves(goal, stance.feet, stance.lean, side, now_)) return std::nullopt;
        return stance;
    }

    bool free_of_part(const Stance& stance) const {
        const Vector2d local = relative_to(trolley(), stance.feet).position;
        const Box& cell = scenario_.cell;
        const Vector2d& p = stance.feet.position;
        return (local.y() < -0.33 || std::abs(local.x()) > 1.3) && p.x() > cell.min.x() + 0.2 &&
               p.x() < cell.max.x() - 0.2 && p.y() > cell.min.y() + 0.2 && p.y() < cell.max.y() - 0.2;
    }

    /// True when the arm reaches, the aimed line meets the skin first at the spot, and arm and trunk keep
    /// clear of it.
    bool solves(const ArmGoal& goal, const FloorPose& feet, double lean, size_t side, double time) const {
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
               clear(places.joints[11 + side], 0.12) &&
               clear(0.5 * (places.joints[1] + places.joints[8]), 0.22);
    }

    /// Adds the scatter of the aimed line about its origin (eye, elbow or wrist) to the goal's spot.
    void scatter(ArmGoal& goal, const Stance& stance, size_t side) {
        const BodyDimensions& d = script_.dimensions;
        const Vector3d spot = script_.surroundings(now_).world_from_part * goal.spot;
        BodyPose pose = stand(d, {stance.feet, Vector2d::Zero(), 0}, stance.lean, 0, now_);
        look_at(d, pose, spot, 1);
        const double length = goal.mode == AimMode::eye       ? (spot - eye_of(d, pose)).norm()
                              : goal.mode == AimMode::forearm ? d.forearm() + d.hand() + goal.gap
                                                              : d.hand() + goal.gap;
        const Vector3d line = (spot - shoulder_of(d, pose, side)).normalized();
        const Vector3d u = line.unitOrthogonal(), v = line.cross(u);
        const double sigma = scenario_.worker.scatter * length;
        const Vector3d offset = sigma * (draw_.normal() * u + draw_.normal() * v);
        goal.spot += script_.surroundings(now_).world_from_part.rotation.transpose() * offset;
    }

    std::optional<std::pair<SkinSpot, Stance>> find_stance(const ScenarioAction& action, size_t side) {
        const Vector3d right = script_.trolley_from_part.rotation.transpose() * Vector3d::UnitX();
        for (int attempt = 0; attempt < 600; ++attempt) {
            const auto spot = action.target ? spots_.at(*action.target) : spots_.draw(draw_);
            if (!spot) {
                trouble(action.target
                            ? "key \"target\" is not a point of the part's outer skin that faces the worker"
                            : "the part has no skin that faces the worker");
                return std::nullopt;
            }
            if (!action.target) {
                const double across = (spot->position - spots_.middle()).dot(right) * (side == 1 ? 1 : -1);
                if (across < -0.35 * spots_.half_width()) continue;  // the other arm's side
                const bool used =
                    std::any_of(script_.gestures.begin(), script_.gestures.end(), [&](const HeldGesture& g) {
                        return g.pointing.target_part &&
                               (*g.pointing.target_part - spot->position).norm() < 0.15;
                    });
                if (used && attempt < 400) continue;
            }
            ArmGoal goal = aiming_goal(*spot);
            if (action.touch) goal.gap = 0.002;
            if (const auto stance = draw_stance(*spot, side, goal)) return std::pair{*spot, *stance};
        }
        trouble("no stance was found from which the worker's arm reaches the spot");
        return std::nullopt;
    }

    size_t choose_side(const ScenarioAction& action) {
        const bool left = action.left_arm.value_or(left_next_);
        left_next_ = !left;
        return left ? 0 : 1;
    }

    bool point(const ScenarioAction& action) {
        const size_t side = choose_side(action);
        auto found = find_stance(action, side);
        if (!found) return false;
        auto& [spot, stance] = *found;
        walk(stance.feet);
        ArmGoal goal = stance.goal;
        scatter(goal, stance, side);
        const double reach = draw_.uniform(0.75, 1.05), start = now_;
        const double seconds =
            action.seconds.value_or(action.meant ? draw_.uniform(1.4, 2.0) : draw_.uniform(0.4, 0.6));
        script_.worker.lean.move(start, start + 0.9 * reach, stance.lean);
        script_.worker.arms[side].go(start, start + reach, goal);
        const double end = start + reach + seconds;
        hold(start + reach, end, side, action.meant, action.touch, spot.position);
        script_.worker.gazes.push_back({start - 0.1, end + 0.4, spot.position});
        relax(side, end);
        return true;
    }

    void relax(size_t side, double from) {
        now_ = from + draw_.uniform(0.55, 0.75);
        script_.worker.arms[side].go(from, now_, {});
    }

    void hold(double t0, double t1, size_t side, bool meant, bool touch, std::optional<Vector3d> target) {
        const int number = static_cast<int>(script_.gestures.size()) + 1;
        script_.gestures.push_back({t0, t1, {number, side == 0, meant, touch, target}});
    }

    /// The stretched arm goes along the part without stopping.
    bool pass(const ScenarioAction& action) {
        const size_t side = choose_side(action);
        const auto found = find_stance(action, side);
        if (!found) return false;
        const auto& [spot, stance] = *found;
        walk(stance.feet);
        const double seconds = action.seconds.value_or(draw_.uniform(1.1, 1.4)), start = now_;
        const Vector3d along = script_.trolley_from_part.rotation.transpose() * Vector3d::UnitX();
        const double sign = draw_.coin() ? 1 : -1;
        ArmGoal goal = stance.goal;
        goal.task = ArmTask::sweep;
        goal.spot = spot.position - sign * 0.3 * along;
        goal.spot_to = spot.position + sign * 0.3 * along;
        goal.gap = std::max(goal.gap, 0.1);
        goal.sweep_from = start + 0.55;
        goal.sweep_to = goal.sweep_from + seconds;
        script_.worker.lean.move(start, start + 0.7, stance.lean);
        script_.worker.arms[side].go(start, start + 0.8, goal);
        hold(start + 0.8, goal.sweep_to - 0.15, side, false, false, std::nullopt);
        relax(side, goal.sweep_to - 0.15);
        return true;
    }

    /// Stands along the part, the hand next to it at the hip: the elbow sticks out towards the skin.
    bool hand_at_hip(const ScenarioAction& action) {
        const size_t side = choose_side(action);
        const double turn = side == 0 ? -std::numbers::pi / 2 : std::numbers::pi / 2;
        const double x =
            std::clamp(relative_to(trolley(), script_.worker.feet.end()).position.x(), -0.6, 0.6);
        walk(compose(trolley(), {{x, -0.60 - 0.08 * (script_.dimensions.height - 1.6)}, turn}));
        return gesture_of_rest(ArmTask::hip, side, action.seconds.value_or(draw_.uniform(1.8, 2.4)));
    }

    bool scratch(const ScenarioAction& action) {
        return gesture_of_rest(ArmTask::scratch, choose_side(action),
                               action.seconds.value_or(draw_.uniform(1.4, 2.0)));
    }

    bool gesture_of_rest(ArmTask task, size_t side, double seconds) {
        script_.worker.lean.move(now_, now_ + 0.7, 0.03);
        script_.worker.arms[side].go(now_, now_ + 0.8, {.task = task});
        hold(now_ + 0.8, now_ + 0.8 + seconds, side, false, false, std::nullopt);
        relax(side, now_ + 0.8 + seconds);
        return true;
    }

    bool lean_over(const ScenarioAction& action) {
        const double seconds = action.seconds.value_or(draw_.uniform(1.2, 1.8));
        const double before = script_.worker.lean.end();
        script_.worker.lean.move(now_, now_ + 0.8, 0.38);
        script_.worker.lean.move(now_ + 0.8 + seconds, now_ + 1.6 + seconds, std::min(before, 0.1));
        now_ += 1.6 + seconds;
        return true;
    }

    bool trouble(std::string sentence) {
        trouble_ = std::move(sentence);
        return false;
    }

  public:
    /// Behind an end of the trolley (-1 or 1), hands in front of its bar, trolley frame.
    static FloorPose end_stance(double end) {
        return {{end * 1.40, 0.29}, end < 0 ? -std::numbers::pi / 2 : std::numbers::pi / 2};
    }

  private:
    const Scenario& scenario_;
    DrawSequence draw_;
    const RayCaster& caster_;
    SkinSpots spots_;
    CellScript script_;
    bool left_next_;
    double now_ = 0;
    std::string trouble_;
};

FloorPose start_of_worker(const Scenario& scenario) {
    if (scenario.worker.start) return *scenario.worker.start;
    const FloorPose& trolley = scenario.part.start;
    const auto first = std::find_if(scenario.actions.begin(), scenario.actions.end(),
                                    [](const ScenarioAction& a) { return a.kind != ActionKind::wait; });
    if (first != scenario.actions.end() && first->kind == ActionKind::push && first->by_end)
        return compose(trolley,
                       Planner::end_stance(relative_to(trolley, first->to).position.x() >= 0 ? -1 : 1));
    return compose(trolley, {{0, -0.8}, 0});
}

}  // namespace

ArmSurroundings CellScript::surroundings(double time) const {
    ArmSurroundings around;
    around.world_from_trolley = world_from_floor_pose(trolley.at(time).pose);
    around.world_from_part = around.world_from_trolley * trolley_from_part;
    around.time = time;
    return around;
}

RigidTransform mount_part(const ScenarioPart& part, const SurfaceMesh& mesh) {
    RigidTransform trolley_from_part{part.mounting, part.mounting_position.value_or(Vector3d::Zero())};
    if (part.mounting_position || mesh.vertices.empty()) return trolley_from_part;
    SurfaceMesh turned = mesh;
    for (Eigen::Vector3f& v : turned.vertices) v = part.mounting.cast<float>() * v;
    const MeshBounds b = bounds_of(turned);
    trolley_from_part.translation = {-0.5 * (b.min.x() + b.max.x()), -0.06 - b.min.y(),
                                     part.lower_edge - b.min.z()};
    return trolley_from_part;
}

Result<CellScript> plan_script(const Scenario& scenario, uint64_t seed, const SurfaceMesh& part,
                               const RayCaster& part_caster) {
    DrawSequence body(seed, 3);
    CellScript script;
    const double height = body.uniform(1.55, 1.95), girth = body.uniform(0.9, 1.18);
    script.dimensions.height = scenario.worker.height.value_or(height);
    script.dimensions.girth = scenario.worker.build.value_or(girth);
    script.aim = scenario.worker.aim.value_or(static_cast<AimMode>(body.index(3)));
    script.trolley_from_part = mount_part(scenario.part, part);
    script.trolley = FloorTrack(scenario.part.start);
    script.worker = WorkerTracks(start_of_worker(scenario));
    return Planner(scenario, seed, part, part_caster, std::move(script)).run();
}

}  // namespace deixis
