// BVH: a tree of joints with offsets and channels, then one line of numbers a frame.
#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <numbers>
#include <sstream>

#include "appliance/simulation/clip_joints.h"
#include "appliance/simulation/motion_clip.h"

namespace deixis {
namespace {

constexpr size_t most_nodes = 1000, most_frames = 1'000'000;

struct BvhNode {
    std::string name;
    int parent = -1;
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    Eigen::Vector3d end_site = Eigen::Vector3d::Zero();
    std::vector<std::pair<char, bool>> channels;  ///< axis, true = rotation
    int first_child = -1;
};

class BvhReader {
  public:
    BvhReader(const std::string& text, std::string name) : lines_(text), name_(std::move(name)) {}

    Result<MotionClip> read() {
        if (!expect("HIERARCHY") || !expect("ROOT") || !read_node(-1)) return refused();
        std::vector<std::string> names;
        names.reserve(nodes_.size());
        for (const BvhNode& node : nodes_) names.push_back(node.name);
        auto picker = ClipJointPicker::create(names, name_);
        if (!picker) return tl::unexpected(picker.error());
        return read_motion(*picker);
    }

  private:
    bool word(std::string& out) {
        while (!(current_ >> out)) {
            std::string line;
            if (!std::getline(lines_, line)) return refuse("the file ends too early");
            ++line_;
            current_ = std::istringstream(line);
        }
        return true;
    }

    bool expect(const std::string& wanted) {
        std::string got;
        if (!word(got)) return false;
        return got == wanted || refuse("expected \"" + wanted + "\", not \"" + got.substr(0, 40) + "\"");
    }

    bool number(double& out) {
        std::string got;
        if (!word(got)) return false;
        const char* from = got.data() + (got[0] == '+' ? 1 : 0);
        const auto [end, problem] = std::from_chars(from, got.data() + got.size(), out);
        const bool good = problem == std::errc() && end == got.data() + got.size() && std::isfinite(out) &&
                          std::abs(out) < 1e9;
        return good || refuse("expected a number, not \"" + got.substr(0, 40) + "\"");
    }

    bool read_node(int parent, int depth = 0) {
        if (nodes_.size() >= most_nodes || depth > 200) return refuse("the skeleton is larger than a body's");
        const auto index = static_cast<int>(nodes_.size());
        BvhNode node;
        node.parent = parent;
        if (!word(node.name) || !expect("{") || !expect("OFFSET")) return false;
        for (int i = 0; i < 3; ++i)
            if (!number(node.offset[i])) return false;
        if (!expect("CHANNELS") || !read_channels(node)) return false;
        nodes_.push_back(node);
        if (parent >= 0 && nodes_[parent].first_child < 0) nodes_[parent].first_child = index;
        std::string next;
        while (word(next)) {
            if (next == "}") return true;
            if (next == "JOINT") {
                if (!read_node(index, depth + 1)) return false;
            } else if (next == "End") {
                if (!expect("Site") || !expect("{") || !expect("OFFSET")) return false;
                for (int i = 0; i < 3; ++i)
                    if (!number(nodes_[index].end_site[i])) return false;
                if (!expect("}")) return false;
            } else {
                return refuse("expected JOINT, End Site or }, not \"" + next.substr(0, 40) + "\"");
            }
        }
        return false;
    }

    bool read_channels(BvhNode& node) {
        double count = 0;
        if (!number(count)) return false;
        if (count < 0 || count > 6 || count != std::floor(count)) return refuse("CHANNELS must be 0 to 6");
        for (int i = 0; i < static_cast<int>(count); ++i) {
            std::string channel;
            if (!word(channel)) return false;
            const std::string rest = channel.substr(1);
            if (std::string("XYZ").find(channel[0]) == std::string::npos ||
                (rest != "position" && rest != "rotation"))
                return refuse("unknown channel \"" + channel.substr(0, 40) + "\"");
            node.channels.emplace_back(channel[0], rest == "rotation");
        }
        return true;
    }

    Result<MotionClip> read_motion(ClipJointPicker& picker) {
        MotionClip clip;
        double count = 0;
        if (!expect("MOTION") || !expect("Frames:") || !number(count)) return refused();
        if (count < 1 || count > static_cast<double>(most_frames)) {
            refuse("Frames must be 1 to " + std::to_string(most_frames));
            return refused();
        }
        if (!expect("Frame") || !expect("Time:") || !number(clip.seconds_per_frame)) return refused();
        if (clip.seconds_per_frame <= 1e-4 || clip.seconds_per_frame > 1) {
            refuse("Frame Time must be above 0.0001 and at most 1 second");
            return refused();
        }
        for (int f = 0; f < static_cast<int>(count); ++f) {
            std::vector<ClipNode> places;
            if (!read_frame(places)) return refused();
            auto frame = picker.frame(places);
            if (!frame) return tl::unexpected(frame.error());
            clip.frames.push_back(*frame);
        }
        std::string more;
        if (current_ >> more || lines_ >> more) {
            refuse("numbers after the last frame");
            return refused();
        }
        return clip;
    }

    bool read_frame(std::vector<ClipNode>& places) {
        std::vector<Eigen::Matrix3d> rotations;
        for (const BvhNode& node : nodes_) {
            Eigen::Vector3d offset = node.offset;
            Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
            for (const auto& [axis, turns] : node.channels) {
                double value = 0;
                if (!number(value)) return false;
                const int i = axis - 'X';
                if (turns)
                    rotation =
                        rotation * Eigen::AngleAxisd(value * std::numbers::pi / 180, Eigen::Vector3d::Unit(i))
                                       .toRotationMatrix();
                else
                    offset[i] = value;  // a joint's position channels stand in place of its offset
            }
            const bool root = node.parent < 0;
            const Eigen::Matrix3d parent = root ? Eigen::Matrix3d::Identity() : rotations[node.parent];
            const Eigen::Vector3d start =
                (root ? Eigen::Vector3d::Zero() : places[node.parent].start) + parent * offset;
            rotations.emplace_back(parent * rotation);
            places.push_back({node.name, start, start + rotations.back() * node.end_site});
            if (!root && nodes_[node.parent].first_child == static_cast<int>(places.size()) - 1)
                places[node.parent].end = start;
        }
        return true;
    }

    bool refuse(const std::string& what) {
        if (complaint_.empty()) complaint_ = name_ + ": line " + std::to_string(line_) + ": " + what;
        return false;
    }
    tl::unexpected<Failure> refused() const { return fail(complaint_); }

    std::istringstream lines_, current_;
    std::string name_, complaint_;
    size_t line_ = 0;
    std::vector<BvhNode> nodes_;
};

}  // namespace

Result<MotionClip> parse_bvh(const std::string& text, const std::string& name) {
    return BvhReader(text, name).read();
}

Result<MotionClip> read_bvh(const std::filesystem::path& file) {
    const auto text = read_clip_text(file);
    if (!text) return tl::unexpected(text.error());
    return parse_bvh(*text, file.string());
}

}  // namespace deixis
