// ASF skeletons (Acclaim: bones with direction, length and own axes) and AMC motion.
#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "appliance/simulation/clip_joints.h"
#include "appliance/simulation/motion_clip.h"

namespace deixis {
namespace {

constexpr double cmu_frames_per_second = 120;

Eigen::Matrix3d turned_about(int axis, double degrees) {
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d::Unit(axis))
        .toRotationMatrix();
}

/// x first, then y, then z.
Eigen::Matrix3d turned_xyz(const Eigen::Vector3d& degrees) {
    return turned_about(2, degrees.z()) * turned_about(1, degrees.y()) * turned_about(0, degrees.x());
}

struct AsfBone {
    std::string name;
    Eigen::Vector3d way = Eigen::Vector3d::Zero();       ///< direction times length
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< of the bone's own rotations
    std::vector<int> free;                               ///< axes about which it turns, in file order
    int parent = -1;                                     ///< -1 = the root
};

struct Lines {
    std::istringstream text;
    std::string name, line, complaint;
    size_t number = 0;

    Lines(const std::string& from, std::string as) : text(from), name(std::move(as)) {}
    bool next() {
        while (std::getline(text, line)) {
            ++number;
            if (!line.empty() && line.back() == '\r') line.pop_back();
            const size_t start = line.find_first_not_of(" \t");
            if (start == std::string::npos || line[start] == '#') continue;
            line.erase(0, start);
            return true;
        }
        return false;
    }
    bool refuse(const std::string& what) {
        if (complaint.empty()) complaint = name + ": line " + std::to_string(number) + ": " + what;
        return false;
    }
};

std::vector<std::string> words_of(const std::string& line) {
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string w; in >> w;) words.push_back(w);
    return words;
}

bool number_of(const std::string& word, double& out) {
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), out);
    return problem == std::errc() && end == word.data() + word.size() && std::isfinite(out) &&
           std::abs(out) < 1e9;
}

class AsfSkeleton {
  public:
    std::vector<AsfBone> bones;

    bool read(Lines& in) {
        std::string section;
        while (in.next()) {
            if (in.line[0] == ':') {
                section = words_of(in.line)[0];
                continue;
            }
            const auto words = words_of(in.line);
            if (section == ":bonedata" && words[0] == "begin" && !read_bone(in)) return false;
            if (section == ":hierarchy" && words[0] != "begin" && words[0] != "end" &&
                !read_children(in, words))
                return false;
        }
        if (bones.empty()) return in.refuse("the skeleton has no bones");
        for (size_t i = 0; i < bones.size(); ++i)
            if (bones[i].parent >= static_cast<int>(i))
                return in.refuse("bone \"" + bones[i].name + "\" stands before its parent");
        return true;
    }

    int find(const std::string& name) const {
        const auto at =
            std::find_if(bones.begin(), bones.end(), [&](const AsfBone& b) { return b.name == name; });
        return at == bones.end() ? -1 : static_cast<int>(at - bones.begin());
    }

  private:
    bool read_bone(Lines& in) {
        AsfBone bone;
        Eigen::Vector3d direction = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::Zero();
        double length = 0;
        while (in.next()) {
            const auto words = words_of(in.line);
            const auto three = [&](Eigen::Vector3d& out) {
                for (size_t i = 0; i < 3; ++i)
                    if (words.size() < i + 2 || !number_of(words[i + 1], out[static_cast<int>(i)]))
                        return in.refuse("\"" + words[0] + "\" needs three numbers");
                return true;
            };
            if (words[0] == "end") {
                if (bone.name.empty()) return in.refuse("a bone without a name");
                if (find(bone.name) >= 0) return in.refuse("bone \"" + bone.name + "\" is given twice");
                bone.way = length * direction;
                bone.axes = turned_xyz(axis);
                bones.push_back(bone);
                return bones.size() < 1000 || in.refuse("the skeleton is larger than a body's");
            }
            if (words[0] == "name" && words.size() > 1) bone.name = words[1];
            if (words[0] == "direction" && !three(direction)) return false;
            if (words[0] == "axis" && !three(axis)) return false;
            if (words[0] == "length" && (words.size() < 2 || !number_of(words[1], length)))
                return in.refuse("\"length\" needs a number");
            if (words[0] != "dof") continue;
            for (size_t i = 1; i < words.size(); ++i) {
                if (words[i] != "rx" && words[i] != "ry" && words[i] != "rz")
                    return in.refuse("only rx, ry and rz are read as \"dof\", not \"" +
                                     words[i].substr(0, 40) + "\"");
                bone.free.push_back(words[i][1] - 'x');
            }
        }
        return in.refuse("the file ends inside a bone");
    }

    bool read_children(Lines& in, const std::vector<std::string>& words) {
        const int parent = find(words[0]);
        if (parent < 0 && words[0] != "root")
            return in.refuse("unknown bone \"" + words[0].substr(0, 40) + "\"");
        for (size_t i = 1; i < words.size(); ++i) {
            const int child = find(words[i]);
            if (child < 0) return in.refuse("unknown bone \"" + words[i].substr(0, 40) + "\"");
            bones[child].parent = parent;
        }
        return true;
    }
};

/// The bones' places of one frame, from the root's motion and each bone's angles.
std::vector<ClipNode> place_bones(const AsfSkeleton& skeleton, const Eigen::Vector3d& root,
                                  const Eigen::Matrix3d& root_turn,
                                  const std::vector<Eigen::Vector3d>& degrees) {
    std::vector<ClipNode> nodes{{"root", root, root}};
    std::vector<Eigen::Matrix3d> turns{root_turn};
    for (size_t i = 0; i < skeleton.bones.size(); ++i) {
        const AsfBone& bone = skeleton.bones[i];
        const Eigen::Matrix3d turn =
            turns[bone.parent + 1] * bone.axes * turned_xyz(degrees[i]) * bone.axes.transpose();
        const Eigen::Vector3d start = nodes[bone.parent + 1].end;
        turns.push_back(turn);
        nodes.push_back({bone.name, start, start + turn * bone.way});
    }
    return nodes;
}

Result<MotionClip> read_motion(const AsfSkeleton& skeleton, Lines& in, ClipJointPicker& picker) {
    MotionClip clip;
    clip.seconds_per_frame = 1 / cmu_frames_per_second;
    Eigen::Vector3d root = Eigen::Vector3d::Zero(), root_turn = Eigen::Vector3d::Zero();
    std::vector<Eigen::Vector3d> degrees(skeleton.bones.size(), Eigen::Vector3d::Zero());
    bool open = false;
    const auto close = [&]() -> Result<void> {
        if (!open) return {};
        auto frame = picker.frame(place_bones(skeleton, root, turned_xyz(root_turn), degrees));
        if (!frame) return tl::unexpected(frame.error());
        clip.frames.push_back(*frame);
        return {};
    };
    while (in.next()) {
        if (in.line[0] == ':') continue;
        const auto words = words_of(in.line);
        double value = 0;
        if (words.size() == 1 && number_of(words[0], value)) {
            if (auto done = close(); !done) return tl::unexpected(done.error());
            open = true;
            continue;
        }
        std::vector<double> values;
        for (size_t i = 1; i < words.size(); ++i) {
            if (!number_of(words[i], value)) {
                in.refuse("expected a number, not \"" + words[i].substr(0, 40) + "\"");
                return fail(in.complaint);
            }
            values.push_back(value);
        }
        const int bone = skeleton.find(words[0]);
        const size_t wanted = words[0] == "root" ? 6 : bone >= 0 ? skeleton.bones[bone].free.size() : 0;
        if (!open || (words[0] != "root" && bone < 0) || values.size() != wanted) {
            in.refuse(!open ? "a bone before the first frame's number"
                      : words[0] != "root" && bone < 0
                          ? "unknown bone \"" + words[0].substr(0, 40) + "\""
                          : "bone \"" + words[0] + "\" needs " + std::to_string(wanted) + " numbers");
            return fail(in.complaint);
        }
        if (words[0] == "root") {
            root = {values[0], values[1], values[2]};
            root_turn = {values[3], values[4], values[5]};
            continue;
        }
        for (size_t i = 0; i < wanted; ++i) degrees[bone][skeleton.bones[bone].free[i]] = values[i];
    }
    if (auto done = close(); !done) return tl::unexpected(done.error());
    if (clip.frames.empty()) return fail(in.name + ": holds no frame");
    return clip;
}

}  // namespace

Result<MotionClip> parse_asf_amc(const std::string& skeleton_text, const std::string& skeleton_name,
                                 const std::string& clip_text, const std::string& clip_name) {
    AsfSkeleton skeleton;
    Lines asf(skeleton_text, skeleton_name), amc(clip_text, clip_name);
    if (!skeleton.read(asf)) return fail(asf.complaint);
    std::vector<std::string> names{"root"};
    for (const AsfBone& bone : skeleton.bones) names.push_back(bone.name);
    auto picker = ClipJointPicker::create(names, skeleton_name);
    if (!picker) return tl::unexpected(picker.error());
    return read_motion(skeleton, amc, *picker);
}

Result<MotionClip> read_asf_amc(const std::filesystem::path& skeleton, const std::filesystem::path& clip) {
    const auto asf = read_clip_text(skeleton);
    if (!asf) return tl::unexpected(asf.error());
    const auto amc = read_clip_text(clip);
    if (!amc) return tl::unexpected(amc.error());
    return parse_asf_amc(*asf, skeleton.string(), *amc, clip.string());
}

}  // namespace deixis
