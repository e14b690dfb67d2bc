// truth.jsonl: reading, checking, and the true part pose between two lines.
#include "appliance/acceptance/truth_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string_view>

#include "appliance/acceptance/json_line.h"

namespace deixis {

namespace {

constexpr std::array<std::string_view, 15> joint_names = {
    "head",        "neck",       "left_shoulder", "right_shoulder", "left_elbow",
    "right_elbow", "left_wrist", "right_wrist",   "pelvis",         "left_hip",
    "right_hip",   "left_knee",  "right_knee",    "left_ankle",     "right_ankle"};

constexpr int64_t longest_gap_us = 100'000;  // between two lines that may be interpolated
constexpr int64_t nearest_us = 17'000;       // the pairing window of formats.md

TruthPointing read_truth_pointing(const JsonObject& pointing) {
    TruthPointing out;
    out.hold = pointing.integer("hold");
    if (out.hold && *out.hold < 1)
        pointing.refuse("pointing.hold is " + std::to_string(*out.hold) + ", expected 1 or more");
    out.arm = pointing.arm("arm");
    out.meant = pointing.boolean("meant");
    out.touch = pointing.boolean("touch");
    out.target_part = pointing.vector("target_part");
    return out;
}

TruthFrame read_frame(const JsonObject& line, std::set<std::string>& seen,
                      std::vector<std::string>& warnings) {
    TruthFrame frame;
    const std::optional<int64_t> stamp = line.integer("timestamp_us");
    if (!stamp) line.refuse("timestamp_us is missing");
    frame.timestamp_us = *stamp;
    line.warn_unknown({"timestamp_us", "joints", "part", "pointing"}, seen, warnings);
    if (const auto joints = line.object("joints")) {
        for (const std::string_view joint : joint_names) {
            const std::string name(joint);
            if (const auto position = joints->vector(name.c_str())) frame.joints[name] = *position;
        }
        joints->warn_unknown(joint_names, seen, warnings);
    }
    if (const auto part = line.object("part")) {
        frame.part_rotation = part->rotation("rotation");
        frame.part_translation = part->vector("translation");
        part->warn_unknown({"rotation", "translation"}, seen, warnings);
    }
    if (const auto pointing = line.object("pointing")) {
        frame.pointing = read_truth_pointing(*pointing);
        pointing->warn_unknown({"hold", "arm", "meant", "touch", "target_part"}, seen, warnings);
    }
    return frame;
}

/// One value of the truth at `time`: `take` gives it from a line or nothing, `blend` mixes two with weight 0
/// to 1.
template <class Value, class Take, class Blend>
std::optional<Value> value_at(const std::vector<TruthFrame>& frames, int64_t time, Take take, Blend blend) {
    const auto stamp_below = [](const TruthFrame& frame, int64_t t) { return frame.timestamp_us < t; };
    const auto after = std::lower_bound(frames.begin(), frames.end(), time, stamp_below);
    // Stamps may be anything an int64_t holds, so gaps are taken in double.
    const auto gap = [time](const TruthFrame& frame) {
        return std::abs(double(frame.timestamp_us) - double(time));
    };
    const auto too_far = [&](const TruthFrame& frame) { return gap(frame) > double(longest_gap_us); };
    const TruthFrame* later = nullptr;
    for (auto it = after; it != frames.end() && !too_far(*it) && later == nullptr; ++it) {
        if (take(*it)) later = &*it;
    }
    const TruthFrame* earlier = nullptr;
    for (auto it = after; it != frames.begin() && !too_far(*std::prev(it)) && earlier == nullptr; --it) {
        if (take(*std::prev(it))) earlier = &*std::prev(it);
    }
    if (later != nullptr && later->timestamp_us == time) return take(*later);
    const double to_later = later == nullptr ? 1e30 : gap(*later);
    const double to_earlier = earlier == nullptr ? 1e30 : gap(*earlier);
    if (to_later + to_earlier <= double(longest_gap_us)) {
        return blend(*take(*earlier), *take(*later), to_earlier / (to_later + to_earlier));
    }
    const TruthFrame* nearest = to_earlier <= to_later ? earlier : later;
    if (std::min(to_earlier, to_later) <= double(nearest_us)) return take(*nearest);
    return std::nullopt;
}

}  // namespace

Result<Truth> read_truth(std::istream& in, const std::string& name) {
    Truth truth;
    std::set<std::string> seen;
    std::map<int64_t, bool> meant_of_hold;
    const Result<size_t> lines = read_json_lines(in, name, [&](const JsonObject& line) {
        TruthFrame frame = read_frame(line, seen, truth.warnings);
        if (frame.pointing && frame.pointing->hold && frame.pointing->meant) {
            const auto [known, added] = meant_of_hold.emplace(*frame.pointing->hold, *frame.pointing->meant);
            if (known->second != *frame.pointing->meant) {
                line.refuse("pointing.meant of hold " + std::to_string(known->first) +
                            " differs from an earlier line");
            }
        }
        truth.frames.push_back(std::move(frame));
    });
    if (!lines) return tl::unexpected<Failure>(lines.error());
    std::stable_sort(truth.frames.begin(), truth.frames.end(), [](const TruthFrame& a, const TruthFrame& b) {
        return a.timestamp_us < b.timestamp_us;
    });
    return truth;
}

Result<Truth> read_truth(const std::filesystem::path& path) {
    std::ifstream in(path);
    if (!in || std::filesystem::is_directory(path)) return fail(path.string() + " cannot be read");
    return read_truth(in, path.string());
}

TruthPartPose part_pose_at(const Truth& truth, int64_t timestamp_us) {
    TruthPartPose pose;
    pose.translation = value_at<Eigen::Vector3d>(
        truth.frames, timestamp_us, [](const TruthFrame& frame) { return frame.part_translation; },
        [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double t) -> Eigen::Vector3d {
            return a + t * (b - a);
        });
    pose.rotation = value_at<Eigen::Matrix3d>(
        truth.frames, timestamp_us, [](const TruthFrame& frame) { return frame.part_rotation; },
        [](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b, double t) {
            return Eigen::Quaterniond(a).slerp(t, Eigen::Quaterniond(b)).normalized().toRotationMatrix();
        });
    return pose;
}

}  // namespace deixis
