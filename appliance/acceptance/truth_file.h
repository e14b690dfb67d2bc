// truth.jsonl as a value: what really happened in a session, line by line, read and checked.
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

namespace deixis {

/// The gesture held in one frame; whatever the file left out or gave as null is absent.
struct TruthPointing {
    std::optional<int64_t> hold;  ///< counts the gestures of the session from 1
    std::optional<ArmSide> arm;
    std::optional<bool> meant;  ///< false: must not become a mark
    std::optional<bool> touch;
    std::optional<Eigen::Vector3d> target_part;  ///< the true spot, part frame [m]
};

/// One line. `timestamp_us` may be that of any sensor.
struct TruthFrame {
    int64_t timestamp_us = 0;
    std::map<std::string, Eigen::Vector3d> joints;  ///< world frame [m]; only names of formats.md
    std::optional<Eigen::Matrix3d> part_rotation;   ///< world_from_part
    std::optional<Eigen::Vector3d> part_translation;
    std::optional<TruthPointing> pointing;
};

struct Truth {
    std::vector<TruthFrame> frames;     ///< by rising time; lines of the same stamp in the file's order
    std::vector<std::string> warnings;  ///< unknown keys, one sentence each, the first line that has it
};

/// Reads truth.jsonl. Refuses with one sentence naming file, line and key: not JSON, not an object, no or a
/// fractional `timestamp_us`, vectors of other than three finite numbers, a rotation that is not orthonormal
/// to 1e-4 or is a reflection, an arm that is neither left nor right, a hold below 1, and two lines that
/// contradict each other about what a hold meant. Empty lines are passed over; an empty file is refused.
Result<Truth> read_truth(const std::filesystem::path& path);

/// The same from a stream; `name` stands for the file in sentences.
Result<Truth> read_truth(std::istream& in, const std::string& name);

/// world_from_part at any time: `rotation` and `translation` are absent where the truth does not say.
struct TruthPartPose {
    std::optional<Eigen::Matrix3d> rotation;
    std::optional<Eigen::Vector3d> translation;
};

/// The true part pose at `timestamp_us`: between two lines at most 100 ms apart by linear and spherical
/// interpolation, else that of a line at most 17 ms away. Each half on its own.
TruthPartPose part_pose_at(const Truth& truth, int64_t timestamp_us);

}  // namespace deixis
