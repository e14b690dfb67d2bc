// Names of the part's states.
#include "tracking/part/part_estimate.h"

namespace deixis {

const char* name_of(PartState state) {
    switch (state) {
        case PartState::absent:
            return "absent";
        case PartState::searching:
            return "searching";
        case PartState::ambiguous:
            return "ambiguous";
        case PartState::tracking:
            return "tracking";
        case PartState::lost:
            return "lost";
    }
    return "absent";
}

}  // namespace deixis
