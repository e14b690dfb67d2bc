// Marks frames beyond the pairing window as present while they are near enough.
#include "tracking/volume/frame_gaps.h"

#include <algorithm>
#include <cstdlib>

namespace deixis {

InvalidSettings FrameGaps::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "reach_ms", reach_ms, 0, 200);
    return complaints;
}

bool FrameGaps::fills(const DepthFrame& frame, int64_t timestamp_us) const {
    return !frame.present && !frame.depth.millimetres.empty() &&
           std::abs(frame.timestamp_us - timestamp_us) <= int64_t{1000} * params_.reach_ms;
}

const Frameset& FrameGaps::update(const Frameset& frameset) {
    const auto fill = [&](const DepthFrame& f) { return fills(f, frameset.timestamp_us); };
    // NOLINTNEXTLINE(bugprone-return-const-ref-from-parameter): a temporary is refused by the overload
    if (std::none_of(frameset.frames.begin(), frameset.frames.end(), fill)) return frameset;
    filled_ = frameset;
    for (DepthFrame& frame : filled_.frames) frame.present = frame.present || fill(frame);
    return filled_;
}

}  // namespace deixis
