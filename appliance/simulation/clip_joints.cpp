// Names of joints in the usual capture files.
#include "appliance/simulation/clip_joints.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <sstream>

namespace deixis {
namespace {

std::string plain(const std::string& name) {
    std::string out;
    for (const unsigned char c : name)
        if (std::isalnum(c) != 0) out += static_cast<char>(std::tolower(c));
    return out;
}

struct NamedJoint {
    const char* joint;
    std::vector<const char*>
        left;  ///< best first: "LeftShoulder" is the collar bone where there is a "LeftArm"
    std::vector<const char*> right;  ///< the same for the right; for the middle joints empty
};

const std::vector<NamedJoint>& known_names() {
    static const std::vector<NamedJoint> names{
        {"shoulder",
         {"leftarm", "upperarml", "lhumerus", "leftupperarm", "leftshoulder", "lshoulder"},
         {"rightarm", "upperarmr", "rhumerus", "rightupperarm", "rightshoulder", "rshoulder"}},
        {"elbow",
         {"leftforearm", "lowerarml", "lradius", "leftelbow", "leftlowerarm", "lelbow"},
         {"rightforearm", "lowerarmr", "rradius", "rightelbow", "rightlowerarm", "relbow"}},
        {"wrist",
         {"lefthand", "handl", "lwrist", "leftwrist"},
         {"righthand", "handr", "rwrist", "rightwrist"}},
        {"hip",
         {"leftupleg", "upperlegl", "lfemur", "leftthigh", "lefthip", "lhip"},
         {"rightupleg", "upperlegr", "rfemur", "rightthigh", "righthip", "rhip"}},
        {"knee",
         {"leftleg", "lowerlegl", "ltibia", "leftshin", "leftknee", "lknee"},
         {"rightleg", "lowerlegr", "rtibia", "rightshin", "rightknee", "rknee"}},
        {"ankle",
         {"leftfoot", "footl", "lfoot", "leftankle", "lankle"},
         {"rightfoot", "footr", "rfoot", "rightankle", "rankle"}},
        {"toes",
         {"lefttoebase", "toesl", "ltoes", "lefttoe", "lefttoes"},
         {"righttoebase", "toesr", "rtoes", "righttoe", "righttoes"}},
        {"pelvis", {"hips", "hip", "pelvis", "root"}, {}},
        {"neck", {"neck", "lowerneck", "neck1"}, {}},
        {"head", {"head"}, {}}};
    return names;
}

}  // namespace

Result<ClipJointPicker> ClipJointPicker::create(const std::vector<std::string>& node_names,
                                                const std::string& file) {
    ClipJointPicker picker;
    picker.file_ = file;
    std::string missing;
    const auto find = [&](const std::string& joint,
                          const std::vector<const char*>& names) -> std::optional<size_t> {
        for (const char* name : names) {
            const auto at = std::find_if(node_names.begin(), node_names.end(),
                                         [&](const std::string& n) { return plain(n) == name; });
            if (at != node_names.end()) return static_cast<size_t>(at - node_names.begin());
        }
        if (missing.empty() && joint != "toes") missing = joint;
        return std::nullopt;
    };
    const auto joint = [&](size_t index, size_t side) {
        const NamedJoint& known = known_names()[index];
        return find(known.joint, side == 0 ? known.left : known.right);
    };
    const auto refusal = [&](const std::string& whose) {
        return fail(file + ": the skeleton has no " + whose + missing + " that we know the name of");
    };
    for (size_t side = 0; side < 2; ++side) {
        Sided& s = picker.sides_[side];
        s = {joint(0, side).value_or(0),
             joint(1, side).value_or(0),
             joint(2, side).value_or(0),
             joint(3, side).value_or(0),
             joint(4, side).value_or(0),
             joint(5, side).value_or(0),
             joint(6, side)};
        if (!missing.empty()) return refusal(side == 0 ? "left " : "right ");
    }
    picker.pelvis_ = joint(7, 0).value_or(0);
    picker.neck_ = joint(8, 0).value_or(0);
    picker.head_ = joint(9, 0).value_or(0);
    if (!missing.empty()) return refusal("");
    return picker;
}

Result<ClipFrame> ClipJointPicker::frame(const std::vector<ClipNode>& nodes) {
    ClipFrame frame;
    frame.joints[0] = nodes[head_].end;
    frame.joints[1] = nodes[neck_].start;
    frame.joints[8] = nodes[pelvis_].start;
    for (size_t side = 0; side < 2; ++side) {
        const Sided& s = sides_[side];
        frame.joints[2 + side] = nodes[s.shoulder].start;
        frame.joints[4 + side] = nodes[s.elbow].start;
        frame.joints[6 + side] = nodes[s.wrist].start;
        frame.joints[9 + side] = nodes[s.hip].start;
        frame.joints[11 + side] = nodes[s.knee].start;
        frame.joints[13 + side] = nodes[s.ankle].start;
        frame.toes[side] = s.toes ? nodes[*s.toes].start : nodes[s.ankle].end;
        frame.hand_ends[side] = nodes[s.wrist].end;
    }
    // Hips that start between the hip joints or above them are all the same to us.
    frame.joints[8] = 0.5 * (frame.joints[9] + frame.joints[10]);
    if (!ours_from_clip_) {
        const Eigen::Vector3d up = frame.joints[0] - 0.5 * (frame.joints[13] + frame.joints[14]);
        int axis = 0;
        const double most = up.cwiseAbs().maxCoeff(&axis);
        if (!(most > 0.8 * up.norm()) || axis == 0 || up[axis] < 0)
            return fail(file_ + ": nobody stands upright along y or z in the first frame");
        Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
        if (axis == 1) turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
        ours_from_clip_ = turn;
    }
    for (Eigen::Vector3d& p : frame.joints) p = *ours_from_clip_ * p;
    for (Eigen::Vector3d& p : frame.toes) p = *ours_from_clip_ * p;
    for (Eigen::Vector3d& p : frame.hand_ends) p = *ours_from_clip_ * p;
    return frame;
}

Result<std::string> read_clip_text(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (file && !std::filesystem::is_directory(path)) text << file.rdbuf();
    if (!file || text.str().empty()) return fail(path.string() + ": cannot be read");
    return text.str();
}

}  // namespace deixis
