// Marks to gestures.
#include "appliance/acceptance/mark_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deixis {

namespace {

constexpr double same_gesture_gap_us = 500'000;  // between lines of a gesture without a number
constexpr double arm_memory_us = 1'000'000;

/// Stamps may be anything an int64_t holds, so differences are taken in double.
double elapsed_us(int64_t from, int64_t to) {
    return double(to) - double(from);
}

/// A gesture while its lines are gathered.
struct GatheredHold {
    TruthHold hold;
    std::optional<bool> meant;  ///< of the first line that says it
};

void add_line(GatheredHold& gathered, const TruthFrame& frame) {
    TruthHold& hold = gathered.hold;
    if (!gathered.meant) gathered.meant = frame.pointing->meant;
    hold.last_us = std::max(hold.last_us, frame.timestamp_us);
    if (!hold.arm) hold.arm = frame.pointing->arm;
    if (!hold.target_part) hold.target_part = frame.pointing->target_part;
    hold.touch = hold.touch || frame.pointing->touch.value_or(false);
}

bool same_spot(const std::optional<Eigen::Vector3d>& a, const std::optional<Eigen::Vector3d>& b) {
    return !a || !b || (*a - *b).norm() < 1e-3;
}

bool same_meaning(const std::optional<bool>& a, const std::optional<bool>& b) {
    return !a || !b || *a == *b;
}

GatheredHold* find_hold(std::vector<GatheredHold>& holds, const TruthFrame& frame) {
    if (frame.pointing->hold) {
        const auto same = [&](const GatheredHold& gathered) {
            return gathered.hold.hold == *frame.pointing->hold;
        };
        const auto found = std::find_if(holds.begin(), holds.end(), same);
        return found == holds.end() ? nullptr : &*found;
    }
    const auto continued = [&](const GatheredHold& gathered) {
        return gathered.hold.hold == 0 && same_meaning(gathered.meant, frame.pointing->meant) &&
               same_spot(gathered.hold.target_part, frame.pointing->target_part) &&
               elapsed_us(gathered.hold.last_us, frame.timestamp_us) <= same_gesture_gap_us;
    };
    const auto found = std::find_if(holds.rbegin(), holds.rend(), continued);
    return found == holds.rend() ? nullptr : &*found;
}

std::optional<ArmSide> arm_of_mark(const std::vector<ResultFrame>& frames, size_t index) {
    for (size_t back = index + 1; back-- > 0;) {
        if (elapsed_us(frames[back].timestamp_us, frames[index].timestamp_us) > arm_memory_us)
            return std::nullopt;
        if (frames[back].pointing && frames[back].pointing->arm) return frames[back].pointing->arm;
    }
    return std::nullopt;
}

std::optional<double> distance_to(const TruthHold& hold, const ResultMark& mark) {
    if (!hold.target_part) return std::nullopt;
    return (mark.position_part - *hold.target_part).norm();
}

bool during(const TruthHold& hold, int64_t time, int64_t grace_us) {
    return time >= hold.first_us && elapsed_us(hold.last_us, time) <= double(grace_us);
}

/// Index of the meant gesture that `mark` belongs to.
std::optional<size_t> owner_of(const std::vector<JudgedHold>& holds, const JudgedMark& mark,
                               const MarkMatchingParams& params) {
    bool in_trap = false;
    for (const JudgedHold& hold : holds)
        in_trap = in_trap || (!hold.truth.meant && during(hold.truth, mark.timestamp_us, 0));
    std::optional<size_t> owner;
    double nearest = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < holds.size(); ++i) {
        const TruthHold& hold = holds[i].truth;
        if (!hold.meant || !during(hold, mark.timestamp_us, params.grace_us)) continue;
        const std::optional<double> distance = distance_to(hold, mark.mark);
        const bool near = distance && *distance <= params.tolerance_m;
        if (in_trap && !during(hold, mark.timestamp_us, 0) && !near) continue;
        const double rank = distance.value_or(std::numeric_limits<double>::max());
        if (!owner || rank < nearest) {
            owner = i;
            nearest = rank;
        }
    }
    return owner;
}

void judge_hold(JudgedHold& hold, std::vector<JudgedMark>& marks, double tolerance_m) {
    if (!hold.truth.meant) return;
    if (hold.marks.empty()) {
        hold.verdict = HoldVerdict::missed;
        return;
    }
    const JudgedMark& first = marks[hold.marks.front()];
    hold.distance_m = first.distance_m;
    if (hold.truth.arm && first.arm) hold.arm_right = *hold.truth.arm == *first.arm;
    const bool far = hold.distance_m && *hold.distance_m > tolerance_m;
    hold.verdict = far                     ? HoldVerdict::too_far
                   : hold.marks.size() > 1 ? HoldVerdict::doubled
                                           : HoldVerdict::right;
    for (const size_t index : hold.marks) {
        const bool is_far = marks[index].distance_m && *marks[index].distance_m > tolerance_m;
        const bool is_first = index == hold.marks.front();
        marks[index].verdict = is_far     ? MarkVerdict::too_far
                               : is_first ? MarkVerdict::right
                                          : MarkVerdict::doubled;
    }
}

}  // namespace

std::vector<TruthHold> holds_of(const Truth& truth) {
    std::vector<GatheredHold> gathered;
    int64_t highest = 0;
    for (const TruthFrame& frame : truth.frames) {
        if (!frame.pointing) continue;
        GatheredHold* found = find_hold(gathered, frame);
        if (found == nullptr) {
            gathered.push_back({});
            found = &gathered.back();
            found->hold.hold = frame.pointing->hold.value_or(0);  // 0: numbered below
            found->hold.first_us = found->hold.last_us = frame.timestamp_us;
            highest = std::max(highest, found->hold.hold);
        }
        add_line(*found, frame);
    }
    std::vector<TruthHold> holds;
    for (const GatheredHold& each : gathered) {
        holds.push_back(each.hold);
        holds.back().meant = each.meant.value_or(true);
        if (each.hold.hold == 0 && highest < INT64_MAX) holds.back().hold = ++highest;
    }
    return holds;
}

InvalidSettings MarkMatchingParams::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "tolerance_m", tolerance_m, 1e-3, 10);
    require_range(complaints, "grace_us", double(grace_us), 0, 60e6);
    return complaints;
}

const char* name_of(HoldVerdict verdict) {
    switch (verdict) {
        case HoldVerdict::right:
            return "right";
        case HoldVerdict::missed:
            return "missed";
        case HoldVerdict::doubled:
            return "doubled";
        case HoldVerdict::too_far:
            return "too far";
    }
    return "";
}

const char* name_of(MarkVerdict verdict) {
    switch (verdict) {
        case MarkVerdict::right:
            return "right";
        case MarkVerdict::doubled:
            return "doubled";
        case MarkVerdict::too_far:
            return "too far";
        case MarkVerdict::false_mark:
            return "false";
    }
    return "";
}

size_t MarkMatch::meant_holds() const {
    return static_cast<size_t>(
        std::count_if(holds.begin(), holds.end(), [](const JudgedHold& hold) { return hold.truth.meant; }));
}

size_t MarkMatch::count(HoldVerdict verdict) const {
    return static_cast<size_t>(std::count_if(holds.begin(), holds.end(), [verdict](const JudgedHold& hold) {
        return hold.truth.meant && hold.verdict == verdict;
    }));
}

size_t MarkMatch::false_marks() const {
    return static_cast<size_t>(std::count_if(marks.begin(), marks.end(), [](const JudgedMark& mark) {
        return mark.verdict == MarkVerdict::false_mark;
    }));
}

bool MarkMatch::all_right() const {
    return count(HoldVerdict::right) == meant_holds() && false_marks() == 0;
}

MarkMatch match_marks(const Truth& truth, const Results& results, const MarkMatchingParams& params) {
    MarkMatch match;
    for (const TruthHold& hold : holds_of(truth))
        match.holds.push_back({hold, {}, {}, {}, HoldVerdict::right});
    for (size_t i = 0; i < results.frames.size(); ++i) {
        for (const ResultMark& mark : results.frames[i].marks) {
            JudgedMark judged;
            judged.mark = mark;
            judged.timestamp_us = results.frames[i].timestamp_us;
            judged.arm = arm_of_mark(results.frames, i);
            judged.hold = owner_of(match.holds, judged, params);
            if (judged.hold) {
                judged.distance_m = distance_to(match.holds[*judged.hold].truth, mark);
                match.holds[*judged.hold].marks.push_back(match.marks.size());
            }
            match.marks.push_back(judged);
        }
    }
    for (JudgedHold& hold : match.holds) judge_hold(hold, match.marks, params.tolerance_m);
    return match;
}

}  // namespace deixis
