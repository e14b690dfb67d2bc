// From the named nodes of a captured skeleton to the fifteen joints and our axes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "appliance/simulation/motion_clip.h"

namespace deixis {

/// Where a node of a file's skeleton starts and where its bone ends (the first child's start, or its own end
/// site).
struct ClipNode {
    std::string name;
    Eigen::Vector3d start, end;
};

/// Picks nodes by name once, then turns node positions into frames. Axes are settled by the first frame.
class ClipJointPicker {
  public:
    /// Refuses skeletons that lack a joint, naming it. `file` is for the sentence.
    static Result<ClipJointPicker> create(const std::vector<std::string>& node_names,
                                          const std::string& file);

    /// Nodes in the order of `create`. Refuses a first frame that stands along no axis.
    Result<ClipFrame> frame(const std::vector<ClipNode>& nodes);

  private:
    struct Sided {
        size_t shoulder, elbow, wrist, hip, knee, ankle;
        std::optional<size_t> toes;
    };
    std::string file_;
    size_t pelvis_ = 0, neck_ = 0, head_ = 0;
    std::array<Sided, 2> sides_{};
    std::optional<Eigen::Matrix3d> ours_from_clip_;
};

/// All of `path`, or a sentence.
Result<std::string> read_clip_text(const std::filesystem::path& path);

}  // namespace deixis
