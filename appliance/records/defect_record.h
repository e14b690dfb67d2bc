// One reported defect as the record keeps it: the mark, the part it lies on, and what became of it. Values
// only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gestures/mark.h"

namespace deixis {

/// Given by the ledger on commit, rising from 1, never used twice; 0 = not committed.
using DefectId = int64_t;

enum class DefectState { open, confirmed, withdrawn };

/// "open", "confirmed" or "withdrawn".
const char* name_of(DefectState state);

/// The state of that name; nullopt for any other text.
std::optional<DefectState> defect_state_of(const std::string& name);

struct DefectRecord {
    DefectId id = 0;
    std::string part_type;
    std::string part_serial;
    Mark mark;            ///< part frame [m]; its timestamp_us is on the session's clock
    std::string zone;     ///< empty: in no zone
    int64_t time_us = 0;  ///< microseconds since 1970-01-01 UTC
    DefectState state = DefectState::open;
    std::string source = "live";          ///< "live", or the name of the session that was replayed
    std::optional<int64_t> delivered_us;  ///< when the PLC echoed it (UTC); nullopt: not yet, or no PLC
};

/// A line of a defect's history.
struct StateChange {
    DefectId defect = 0;
    DefectState state = DefectState::open;
    std::string who;      ///< "station" for the first line
    int64_t time_us = 0;  ///< UTC
};

}  // namespace deixis
