// What the part tracker says about one frameset.
#pragma once

#include <string>

#include "tracking/geometry/rigid_transform.h"

namespace deixis {

enum class PartState { absent, searching, ambiguous, tracking, lost };

/// "absent", "searching", "ambiguous", "tracking" or "lost", as in results.jsonl.
const char* name_of(PartState state);

/// `world_from_part`, `at_rest` and `fitness` mean something only in state `tracking`.
struct PartEstimate {
    PartState state = PartState::absent;
    RigidTransform world_from_part;
    bool at_rest = false;  ///< frozen: not moved for the rest time
    double fitness = 0;    ///< share of the visible reference points that were found, 0 to 1
    std::string reason;    ///< why it is not tracking, for the screen; empty when it is
};

}  // namespace deixis
