// Names of the defect states.
#include "appliance/records/defect_record.h"

namespace deixis {

const char* name_of(DefectState state) {
    switch (state) {
        case DefectState::open:
            return "open";
        case DefectState::confirmed:
            return "confirmed";
        case DefectState::withdrawn:
            return "withdrawn";
    }
    return "open";
}

std::optional<DefectState> defect_state_of(const std::string& name) {
    for (const DefectState state : {DefectState::open, DefectState::confirmed, DefectState::withdrawn})
        if (name == name_of(state)) return state;
    return std::nullopt;
}

}  // namespace deixis
