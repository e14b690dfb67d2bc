// Depth background subtraction with a noise-aware threshold, hole filling, drift and moved-background
// updates.
#include "tracking/volume/foreground.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace deixis {
namespace {

/// Grows the known background into unknown pixels, one ring a round, taking the farthest of the known
/// neighbours: a hole at the rim of a thing shows what is behind it.
void fill_holes(std::vector<float>& background, int width, int height, int rounds) {
    std::vector<float> next = background;
    for (int round = 0; round < rounds; ++round) {
        bool filled = false;
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u) {
                const size_t i = static_cast<size_t>(v) * width + u;
                if (background[i] > 0) continue;
                float farthest = 0;
                if (u > 0) farthest = std::max(farthest, background[i - 1]);
                if (u + 1 < width) farthest = std::max(farthest, background[i + 1]);
                if (v > 0) farthest = std::max(farthest, background[i - width]);
                if (v + 1 < height) farthest = std::max(farthest, background[i + width]);
                next[i] = farthest;
                filled = filled || farthest > 0;
            }
        if (!filled) return;
        background = next;
    }
}

}  // namespace

InvalidSettings ForegroundModel::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "base_mm", base_mm, 0, 500);
    require_range(complaints, "step_per_m2", step_per_m2, 0, 0.1);
    require_range(complaints, "threshold_steps", threshold_steps, 0, 20);
    require_range(complaints, "moved_frames", moved_frames, 1, 250);
    require_range(complaints, "drift_rate", drift_rate, 0, 1);
    require_range(complaints, "hole_pixels", hole_pixels, 0, 64);
    require_range(complaints, "neighbours", neighbours, 0, 8);
    return complaints;
}

ForegroundModel::ForegroundModel(std::vector<CalibratedSensor> depth_sensors,
                                 std::vector<std::optional<DepthImage>> background, Params params)
    : params_(params) {
    background.resize(depth_sensors.size());
    for (size_t s = 0; s < depth_sensors.size(); ++s) {
        PerSensor& sensor = sensors_.emplace_back();
        sensor.width = depth_sensors[s].camera.width;
        sensor.height = depth_sensors[s].camera.height;
        const size_t pixels = static_cast<size_t>(sensor.width) * sensor.height;
        sensor.background.assign(pixels, 0);
        sensor.threshold.assign(pixels, threshold_at(0));
        sensor.farther.assign(pixels, 0);
        sensor.candidate.assign(pixels, 0);
        sensor.mask.assign(pixels, 0);
        if (background[s]) set_background(s, *background[s]);
    }
}

void ForegroundModel::set_background(size_t index, const DepthImage& image) {
    PerSensor& sensor = sensors_[index];
    if (image.width != sensor.width || image.height != sensor.height) return;
    std::copy(image.millimetres.begin(), image.millimetres.end(), sensor.background.begin());
    fill_holes(sensor.background, sensor.width, sensor.height, params_.hole_pixels);
    std::transform(sensor.background.begin(), sensor.background.end(), sensor.threshold.begin(),
                   [this](float mm) { return threshold_at(mm); });
    std::fill(sensor.farther.begin(), sensor.farther.end(), uint8_t{0});
}

float ForegroundModel::threshold_at(float depth_mm) const {
    const double z = depth_mm / 1000.0;
    return static_cast<float>(params_.base_mm +
                              params_.threshold_steps * params_.step_per_m2 * z * z * 1000.0);
}

void ForegroundModel::update(const Frameset& frameset) {
    for (size_t s = 0; s < sensors_.size(); ++s) {
        PerSensor& sensor = sensors_[s];
        const bool usable = s < frameset.frames.size() && frameset.frames[s].present &&
                            frameset.frames[s].depth.width == sensor.width &&
                            frameset.frames[s].depth.height == sensor.height;
        if (!usable) {
            std::fill(sensor.mask.begin(), sensor.mask.end(), uint8_t{0});
            continue;
        }
        compare(sensor, frameset.frames[s].depth);
        ask_neighbours(sensor, frameset.frames[s].depth);
    }
}

void ForegroundModel::compare(PerSensor& sensor, const DepthImage& depth) const {
    const auto rate = static_cast<float>(params_.drift_rate);
    const auto moved = static_cast<uint8_t>(params_.moved_frames);
    const size_t pixels = sensor.background.size();
    for (size_t i = 0; i < pixels; ++i) {
        const auto d = static_cast<float>(depth.millimetres[i]);
        const float b = sensor.background[i];
        if (d == 0) {
            sensor.candidate[i] = 0;
            continue;
        }
        const float difference = d - b;
        const float threshold = sensor.threshold[i];
        if (b == 0 || difference < -threshold) {
            sensor.candidate[i] = 1;
            sensor.farther[i] = static_cast<uint8_t>(sensor.farther[i] > 0 ? sensor.farther[i] - 1 : 0);
            continue;
        }
        sensor.candidate[i] = 0;
        if (difference <= threshold) {
            sensor.background[i] = b + rate * difference;
            if (sensor.farther[i] > 0) --sensor.farther[i];
        } else if (++sensor.farther[i] >= moved) {
            sensor.background[i] = d;
            sensor.threshold[i] = threshold_at(d);
            sensor.farther[i] = 0;
        }
    }
}

void ForegroundModel::ask_neighbours(PerSensor& sensor, const DepthImage& depth) const {
    const int w = sensor.width, h = sensor.height;
    std::fill(sensor.mask.begin(), sensor.mask.end(), uint8_t{0});
    for (int v = 0; v < h; ++v) {
        const size_t row = static_cast<size_t>(v) * w;
        for (int u = 0; u < w; ++u) {
            const size_t i = row + u;
            if (!sensor.candidate[i]) continue;
            const int d = depth.millimetres[i];
            // A neighbour counts within two disparity steps and 3 cm; a flying pixel hangs between two
            // surfaces.
            const int like =
                30 + static_cast<int>(2 * params_.step_per_m2 * 1e-3 * static_cast<double>(d) * d);
            int agreeing = 0;
            for (int y = std::max(v - 1, 0); y <= std::min(v + 1, h - 1); ++y)
                for (int x = std::max(u - 1, 0); x <= std::min(u + 1, w - 1); ++x) {
                    const size_t n = static_cast<size_t>(y) * w + x;
                    agreeing += sensor.candidate[n] && std::abs(depth.millimetres[n] - d) <= like;
                }
            sensor.mask[i] = agreeing - 1 >= params_.neighbours;
        }
    }
}

}  // namespace deixis
