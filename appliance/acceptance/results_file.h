// results.jsonl as a value: what a replay said, one line a frameset, read and checked.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gestures/mark.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/rigid_transform.h"
#include "tracking/part/part_estimate.h"

namespace deixis {

struct ResultMark {
    int64_t id = 0;
    Eigen::Vector3d position_part = Eigen::Vector3d::Zero();  ///< [m]
    std::string zone;
};

struct ResultPart {
    PartState state = PartState::absent;
    std::optional<RigidTransform> world_from_part;  ///< stands exactly with state `tracking`
    std::optional<bool> at_rest;
    std::optional<double> fitness;
};

struct ResultPointing {
    std::optional<ArmSide> arm;
    std::optional<Eigen::Vector3d> origin, direction;  ///< world frame [m]
    std::optional<Eigen::Vector3d> hit_part;           ///< part frame [m]
};

struct ResultFrame {
    int64_t timestamp_us = 0;
    std::optional<ResultPart> part;
    std::optional<ResultPointing> pointing;
    std::vector<ResultMark> marks;
    std::map<std::string, double> stage_ms;
};

struct Results {
    std::vector<ResultFrame> frames;    ///< in the file's order, stamps strictly rising
    std::vector<std::string> warnings;  ///< unknown keys, one sentence each, the first line that has it
};

/// Reads results.jsonl. Refuses with one sentence naming file, line and key: not JSON, not an object, no
/// stamp or one that does not rise, an unknown part state, a pose without `tracking` or `tracking` without
/// one, a rotation that is not orthonormal to 1e-4, vectors of other than three finite numbers, an arm that
/// is neither left nor right, a mark without id or position, an id that was there before. Empty lines are
/// passed over; an empty file is refused.
Result<Results> read_results(const std::filesystem::path& path);

/// The same from a stream; `name` stands for the file in sentences.
Result<Results> read_results(std::istream& in, const std::string& name);

}  // namespace deixis
