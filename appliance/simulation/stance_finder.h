// Where to stand and how to hold the arm so that it aims at a spot of the part: drawn, then checked by ray
// casts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "appliance/simulation/counter_random.h"
#include "appliance/simulation/script_planner.h"
#include "appliance/simulation/skin_spots.h"

namespace deixis {

/// Turn of a worker who looks along `direction`; 0 = along +y.
double turn_towards(const Eigen::Vector2d& direction);

struct PointingStance {
    SkinSpot spot;
    FloorPose feet;
    double lean = 0;  ///< [rad]
    ArmGoal goal;
};

/// Works on the script as it stands; all references must outlive it.
class StanceFinder {
  public:
    StanceFinder(const Scenario& scenario, const CellScript& script, const SurfaceMesh& part,
                 const RayCaster& part_caster, DrawSequence& draw);

    /// A stance for `action`'s spot, or for one drawn on the side of the arm and 15 cm from those pointed at
    /// before, with the scatter of the aimed line put on the goal. Nothing when none was found: `trouble`
    /// says why.
    std::optional<PointingStance> find(const ScenarioAction& action, size_t side, double time);

    /// A goal for `side` that the worker reaches without a step from where he is at `time`, leaning by
    /// `lean`.
    std::optional<ArmGoal> reach_from_here(const ScenarioAction& action, size_t side, double lean,
                                           double time);

    const std::string& trouble() const { return trouble_; }

  private:
    std::optional<SkinSpot> next_spot(const ScenarioAction& action);
    bool suits(const SkinSpot& spot, size_t side, bool may_repeat) const;
    ArmGoal aiming_goal(const SkinSpot& spot);
    std::optional<PointingStance> draw_stance(const SkinSpot& spot, size_t side, const ArmGoal& goal,
                                              double time);
    bool free_of_part(const FloorPose& feet, double time) const;
    bool solves(const ArmGoal& goal, const FloorPose& feet, double lean, size_t side, double time) const;
    void scatter(PointingStance& stance, size_t side, bool touch, double time);

    const Scenario& scenario_;
    const CellScript& script_;
    const RayCaster& caster_;
    DrawSequence& draw_;
    SkinSpots spots_;
    std::string trouble_;
};

}  // namespace deixis
