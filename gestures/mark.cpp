// Names of the arms, as in truth.jsonl and results.jsonl.
#include "gestures/mark.h"

namespace deixis {

const char* name_of(ArmSide side) {
    return side == ArmSide::left ? "left" : "right";
}

}  // namespace deixis
