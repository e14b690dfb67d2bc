// Learns the empty cell of a running station. In: framesets; out: backgrounds for the foreground model.
#include "tracking/volume/live_background.h"

#include <algorithm>

namespace deixis {

InvalidSettings LiveBackground::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "every_frames", every_frames, 1, 1000);
    require_range(complaints, "images", images, 3, 10'000);
    return complaints;
}

LiveBackground::LiveBackground(const std::vector<CalibratedSensor>& depth_sensors,
                               const std::vector<std::optional<DepthImage>>& known, Params params)
    : params_(params), learner_(depth_sensors, {}) {
    for (size_t s = 0; s < depth_sensors.size(); ++s)
        missing_.push_back(s < known.size() && known[s] ? 0 : params_.images);
}

bool LiveBackground::done() const {
    return std::all_of(missing_.begin(), missing_.end(), [](int images) { return images == 0; });
}

void LiveBackground::update(const Frameset& frameset, ForegroundModel& foreground) {
    if (done() || framesets_++ % params_.every_frames != 0) return;
    for (size_t s = 0; s < missing_.size() && s < frameset.frames.size(); ++s) {
        if (missing_[s] == 0 || !frameset.frames[s].present) continue;
        learner_.add(s, frameset.frames[s].depth);
        if (--missing_[s] > 0) continue;
        if (const auto learned = learner_.background(); learned[s]) foreground.set_background(s, *learned[s]);
    }
}

}  // namespace deixis
