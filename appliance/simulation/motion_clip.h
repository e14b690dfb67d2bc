// A captured motion as joint positions over time, read from BVH or from ASF with AMC.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

/// One frame: right-handed, Z up, in the clip's own unit. Joints in the order of formats.md; `head` is the
/// end of the head's bone, or its start where the file has no end.
struct ClipFrame {
    std::array<Eigen::Vector3d, 15> joints;
    std::array<Eigen::Vector3d, 2> toes;  ///< left, right; before the ankle where the file has none
    std::array<Eigen::Vector3d, 2>
        hand_ends;  ///< some point farther along the hand; beyond the wrist where it has none
};

struct MotionClip {
    double seconds_per_frame = 0;
    std::vector<ClipFrame> frames;  ///< at least one
};

/// Joints are known by their usual names (Hips, LeftUpLeg, UpperLeg_L, lfemur, ...); the up axis is the one
/// along which the head stands above the ankles in the first frame. Refuses, naming file and line or joint:
/// what does not parse, NaN, missing joints, no frames, fewer or more numbers in a frame than channels.
Result<MotionClip> read_bvh(const std::filesystem::path& file);
Result<MotionClip> parse_bvh(const std::string& text, const std::string& name);

/// `skeleton` is the ASF file of the AMC `clip`; AMC has no frame rate: 120 a second (CMU).
Result<MotionClip> read_asf_amc(const std::filesystem::path& skeleton, const std::filesystem::path& clip);
Result<MotionClip> parse_asf_amc(const std::string& skeleton, const std::string& skeleton_name,
                                 const std::string& clip, const std::string& clip_name);

}  // namespace deixis
