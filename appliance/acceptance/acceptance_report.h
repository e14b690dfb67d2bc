// How well the results of a session agree with its truth: figures, the table for people, the object for
// machines.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "appliance/acceptance/expected_file.h"
#include "appliance/acceptance/mark_matching.h"
#include "appliance/acceptance/results_file.h"
#include "appliance/acceptance/truth_file.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// Order statistics of `count` samples, by the nearest-rank rule; all zero when there is none.
struct SampleSummary {
    size_t count = 0;
    double median = 0, p95 = 0, p99 = 0, max = 0;
};

SampleSummary summarise(std::vector<double> samples);

/// The part's pose over the frames that claim to track it and whose true pose is known.
struct PartPoseFigures {
    size_t frames_with_truth = 0;  ///< the truth knows where the part is
    size_t frames_tracking = 0;    ///< of these
    SampleSummary origin_mm;       ///< distance of the part frame's origins
    SampleSummary rotation_deg;
    SampleSummary corner_mm;  ///< mean displacement of the corners of the part's box; none without the box
};

struct AcceptanceReport {
    MarkMatch marks;
    SampleSummary position_mm;  ///< first mark of every found gesture against its spot
    size_t arms_known = 0, arms_right = 0;
    PartPoseFigures part;
    SampleSummary frame_ms;             ///< stage_ms.total
    std::vector<std::string> failures;  ///< one sentence a criterion that is not met; empty = accepted
};

/// What is demanded of a session beside its figures.
struct Demands {
    std::optional<Expected> expected;  ///< criteria without data fail
    bool every_mark = true;            ///< every meant gesture exactly one mark in its place, no mark false
};

/// The figures of `results`, held against `demands`. `part_box` is the model's box, part frame [m].
AcceptanceReport judge_session(const Truth& truth, const Results& results, const Demands& demands,
                               const std::optional<Box>& part_box, const MarkMatchingParams& params = {});

/// One row a gesture, one a false mark, then the figures and what failed.
std::string table_of(const AcceptanceReport& report);

nlohmann::ordered_json to_json(const AcceptanceReport& report);

}  // namespace deixis
