// Depth modes a pixel, kept online; the farthest well-supported one is the background.
#include "tracking/volume/background_learner.h"

#include <algorithm>
#include <cmath>

namespace deixis {

InvalidSettings BackgroundLearner::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "base_mm", base_mm, 0, 500);
    require_range(complaints, "step_per_m2", step_per_m2, 0, 0.1);
    require_range(complaints, "mode_steps", mode_steps, 0, 20);
    require_range(complaints, "support_frames", support_frames, 1, 1000);
    require_range(complaints, "support_share", support_share, 0, 1);
    return complaints;
}

BackgroundLearner::BackgroundLearner(const std::vector<CalibratedSensor>& depth_sensors, Params params)
    : params_(params) {
    for (const CalibratedSensor& s : depth_sensors) {
        PerSensor& sensor = sensors_.emplace_back();
        sensor.width = s.camera.width;
        sensor.height = s.camera.height;
    }
}

void BackgroundLearner::add(size_t index, const DepthImage& depth) {
    if (index >= sensors_.size()) return;
    PerSensor& sensor = sensors_[index];
    if (depth.width != sensor.width || depth.height != sensor.height) return;
    if (sensor.modes.empty()) sensor.modes.resize(depth.millimetres.size() * kModes);
    ++sensor.images;
    for (size_t i = 0; i < depth.millimetres.size(); ++i) {
        const auto d = static_cast<float>(depth.millimetres[i]);
        if (d == 0) continue;
        const double z = d / 1000.0;
        const auto width =
            static_cast<float>(params_.base_mm + params_.mode_steps * params_.step_per_m2 * z * z * 1000.0);
        Mode* const first = &sensor.modes[i * kModes];
        Mode* const last = first + kModes;
        Mode* nearest = nullptr;
        for (Mode* m = first; m != last; ++m)
            if (m->count > 0 && std::abs(m->mean - d) <= width &&
                (nearest == nullptr || std::abs(m->mean - d) < std::abs(nearest->mean - d)))
                nearest = m;
        if (nearest != nullptr) {
            ++nearest->count;
            nearest->mean += (d - nearest->mean) / static_cast<float>(nearest->count);
            continue;
        }
        // No room: the weakest mode gives way, the nearest of equals, so that a rare far depth outlives
        // passers-by.
        Mode* const weakest = std::min_element(first, last, [](const Mode& a, const Mode& b) {
            return a.count != b.count ? a.count < b.count : a.mean < b.mean;
        });
        *weakest = Mode{d, 1};
    }
}

std::vector<std::optional<DepthImage>> BackgroundLearner::background() const {
    std::vector<std::optional<DepthImage>> images(sensors_.size());
    for (size_t s = 0; s < sensors_.size(); ++s) {
        const PerSensor& sensor = sensors_[s];
        if (sensor.images == 0) continue;
        DepthImage& image = images[s].emplace();
        image.resize(sensor.width, sensor.height);
        for (size_t i = 0; i < image.millimetres.size(); ++i) {
            uint32_t seen = 0;
            for (int k = 0; k < kModes; ++k) seen += sensor.modes[i * kModes + k].count;
            const double needed = std::max<double>(params_.support_frames, params_.support_share * seen);
            float farthest = 0;
            for (int k = 0; k < kModes; ++k) {
                const Mode& m = sensor.modes[i * kModes + k];
                if (m.count > 0 && m.count >= needed) farthest = std::max(farthest, m.mean);
            }
            image.millimetres[i] = static_cast<uint16_t>(std::lround(farthest));
        }
    }
    return images;
}

}  // namespace deixis
