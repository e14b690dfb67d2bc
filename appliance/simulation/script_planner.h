// Turns the scenario's actions into tracks: where the trolley goes, where the worker stands, what his arms do
// when.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "appliance/simulation/scenario.h"
#include "appliance/simulation/virtual_cell.h"
#include "appliance/simulation/worker_motion.h"
#include "tracking/geometry/ray_caster.h"

namespace deixis {

/// A gesture as held from t0 to t1.
struct HeldGesture {
    double t0, t1;
    TruePointing pointing;
};

/// The plan of a session, evaluated at any time.
struct CellScript {
    BodyDimensions dimensions;
    AimMode aim = AimMode::forearm;
    WorkerTracks worker{FloorPose{}};
    FloorTrack trolley{FloorPose{}};
    RigidTransform trolley_from_part;
    std::vector<HeldGesture> gestures;
    double duration = 0;  ///< [s]

    /// Part and trolley at `time`.
    ArmSurroundings surroundings(double time) const;
};

/// Where the part sits on the trolley: as the scenario says, else centred, its front 6 cm before the
/// trolley's origin line and its lowest point at `lower_edge`.
RigidTransform mount_part(const ScenarioPart& part, const SurfaceMesh& mesh);

/// Plays the actions one after the other, drawing from `seed` what they leave open: spots on the outer skin
/// that face the worker, arms, stances, gaps, hold times. Refuses an action whose spot is not on the skin or
/// that the worker cannot reach, naming file and action. `part_caster` holds the part's mesh, part frame.
Result<CellScript> plan_script(const Scenario& scenario, uint64_t seed, const SurfaceMesh& part,
                               const RayCaster& part_caster);

}  // namespace deixis
