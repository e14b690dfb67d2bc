// Which mark belongs to which meant gesture: right, missed, doubled, too far or false.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "appliance/acceptance/results_file.h"
#include "appliance/acceptance/truth_file.h"
#include "gestures/mark.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// One gesture of the truth, from all its lines.
struct TruthHold {
    int64_t hold = 0;
    bool meant = true;  ///< of the first line that says it
    std::optional<ArmSide> arm;
    bool touch = false;
    std::optional<Eigen::Vector3d> target_part;  ///< [m]; of the first line that has it
    int64_t first_us = 0, last_us = 0;
};

/// The gestures in the order of their beginning. Lines of one `hold` number are one gesture; lines without a
/// number form one as long as they follow each other within 0.5 s and name the same spot, and are numbered on
/// from the highest number of the file.
std::vector<TruthHold> holds_of(const Truth& truth);

struct MarkMatchingParams {
    double tolerance_m = 0.1;      ///< a mark farther from the true spot is too far [m]
    int64_t grace_us = 1'500'000;  ///< a mark so long after the gesture's last frame still belongs to it
    InvalidSettings validate() const;
};

/// `right`: exactly one mark, within the tolerance (or the truth names no spot).
enum class HoldVerdict { right, missed, doubled, too_far };
enum class MarkVerdict { right, doubled, too_far, false_mark };

/// "right", "missed", "doubled", "too far".
const char* name_of(HoldVerdict verdict);

/// "right", "doubled", "too far", "false".
const char* name_of(MarkVerdict verdict);

struct JudgedMark {
    ResultMark mark;
    int64_t timestamp_us = 0;
    std::optional<ArmSide>
        arm;  ///< of the pointing on the mark's line, or the last within a second before it
    std::optional<size_t> hold;        ///< index among the judged holds
    std::optional<double> distance_m;  ///< to the true spot
    MarkVerdict verdict = MarkVerdict::false_mark;
};

struct JudgedHold {
    TruthHold truth;
    std::vector<size_t> marks;         ///< indices among the judged marks; only for meant ones
    std::optional<double> distance_m;  ///< of the first mark
    std::optional<bool> arm_right;  ///< the first mark's arm is the true one; absent where either is unknown
    HoldVerdict verdict = HoldVerdict::right;  ///< of a trap: always `right`, its marks are false ones
};

struct MarkMatch {
    std::vector<JudgedHold> holds;
    std::vector<JudgedMark> marks;  ///< in the order of the results

    size_t meant_holds() const;
    size_t count(HoldVerdict verdict) const;  ///< among the meant holds
    size_t false_marks() const;
    bool all_right() const;  ///< every meant hold right, no mark false
};

/// A mark belongs to the meant gesture during which it was made or which ended at most `grace_us` before; if
/// two qualify, to the one whose spot is nearer, and to the earlier if neither names one. A mark during a
/// trap belongs to a gesture that ended before only when it lies within the tolerance of that one's spot.
/// Every other mark is false.
MarkMatch match_marks(const Truth& truth, const Results& results, const MarkMatchingParams& params = {});

}  // namespace deixis
