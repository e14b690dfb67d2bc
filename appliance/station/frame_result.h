// All that the station found in one frameset: the line of results.jsonl and the message of the live stream.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gestures/mark.h"
#include "tracking/part/part_estimate.h"

namespace deixis {

struct CommittedMark {
    int64_t id = 0;
    Mark mark;
    std::string zone;
};

struct StageTimes {
    double foreground = 0, part = 0, carve = 0, worker = 0, gesture = 0, record = 0, total = 0;  ///< [ms]
};

struct FrameResult {
    int64_t timestamp_us = 0;
    PartEstimate part;
    std::optional<PointingRay> pointing;
    std::vector<CommittedMark> marks;
    StageTimes stage_ms;
};

/// The object of formats.md, "results.jsonl"; unknown things are null.
nlohmann::ordered_json to_json(const FrameResult& result);

}  // namespace deixis
