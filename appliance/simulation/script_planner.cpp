// Actions become tracks, one function a kind of action.
#include "appliance/simulation/script_planner.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "appliance/simulation/cell_scenery.h"
#include "appliance/simulation/counter_random.h"
#include "appliance/simulation/stance_finder.h"

namespace deixis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class Planner {
  public:
    Planner(const Scenario& scenario, uint64_t seed, const SurfaceMesh& part, const RayCaster& caster,
            CellScript script)
        : scenario_(scenario),
          draw_(seed, 7),
          script_(std::move(script)),
          stances_(scenario, script_, part, caster, draw_),
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
            const auto goal = stances_.reach_from_here(action, free, lean, 0.5 * (t0 + t1));
            if (!goal) return trouble(stances_.trouble());
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

    // --- pointing ---

    size_t choose_side(const ScenarioAction& action) {
        const bool left = action.left_arm.value_or(left_next_);
        left_next_ = !left;
        return left ? 0 : 1;
    }

    bool point(const ScenarioAction& action) {
        const size_t side = choose_side(action);
        const auto stance = stances_.find(action, side, now_);
        if (!stance) return trouble(stances_.trouble());
        walk(stance->feet);
        const double reach = draw_.uniform(0.75, 1.05), start = now_;
        const double seconds =
            action.seconds.value_or(action.meant ? draw_.uniform(1.4, 2.0) : draw_.uniform(0.4, 0.6));
        script_.worker.lean.move(start, start + 0.9 * reach, stance->lean);
        script_.worker.arms[side].go(start, start + reach, stance->goal);
        const double end = start + reach + seconds;
        hold(start + reach, end, side, action.meant, action.touch, stance->spot.position);
        script_.worker.gazes.push_back({start - 0.1, end + 0.4, stance->spot.position});
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
        const auto stance = stances_.find(action, side, now_);
        if (!stance) return trouble(stances_.trouble());
        walk(stance->feet);
        const double seconds = action.seconds.value_or(draw_.uniform(1.1, 1.4)), start = now_;
        const Vector3d along = script_.trolley_from_part.rotation.transpose() * Vector3d::UnitX();
        const double sign = draw_.coin() ? 1 : -1;
        ArmGoal goal = stance->goal;
        goal.task = ArmTask::sweep;
        goal.spot = stance->spot.position - sign * 0.3 * along;
        goal.spot_to = stance->spot.position + sign * 0.3 * along;
        goal.gap = std::max(goal.gap, 0.1);
        goal.sweep_from = start + 0.55;
        goal.sweep_to = goal.sweep_from + seconds;
        script_.worker.lean.move(start, start + 0.7, stance->lean);
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
    CellScript script_;
    StanceFinder stances_;
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
