// The noise model, pixel by pixel.
#include "appliance/simulation/sensor_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "appliance/simulation/counter_random.h"

namespace deixis {

InvalidSettings SensorNoiseParams::validate() const {
    InvalidSettings bad;
    require_range(bad, "level", level, 0, 10);
    require_range(bad, "step", step, 1e-5, 0.1);
    require_range(bad, "edge_sigma", edge_sigma, 0, 5);
    require_range(bad, "slant_limit", slant_limit, 10, 90);
    require_range(bad, "speckle", speckle, 0, 1);
    require_range(bad, "nearest", nearest, 0.05, 10);
    require_range(bad, "farthest", farthest, nearest, 30);
    return bad;
}

double axial_sigma(double z, double incidence) {
    const double frontal = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
    if (incidence <= std::numbers::pi / 3) return frontal;
    const double rest = std::max(std::numbers::pi / 2 - incidence, 0.02);
    return frontal + 0.0001 / std::sqrt(z) * incidence * incidence / (rest * rest);
}

SensorNoise::SensorNoise(const SensorNoiseParams& params) : params_(params) {
    for (int i = 0; i < depths; ++i)
        for (int j = 0; j < slants; ++j) {
            const double z = 0.3 + 0.05 * i;
            const double share = axial_sigma(z, std::acos((j + 0.5) / slants)) / (params.step * z * z);
            // Rounding to whole steps adds 1/12 of a step squared by itself.
            steps_[i][j] = static_cast<float>(std::sqrt(std::max(share * share - 1.0 / 12, 0.01)));
        }
}

double SensorNoise::steps_of_noise(float z, float cosine) const {
    const int i = std::clamp(static_cast<int>((z - 0.275F) * 20), 0, depths - 1);
    return steps_[i][std::clamp(static_cast<int>(cosine * slants), 0, slants - 1)];
}

void SensorNoise::apply(uint64_t seed, uint64_t frame, const DepthLayer& layer, int width, int height,
                        DepthImage& out) const {
    const SensorNoiseParams& p = params_;
    const CounterRandom random(seed, 0x100000 + frame);
    const double jitter = p.edge_sigma * p.level, per_metre = 1 / p.step;
    const double steepest = std::cos((p.slant_limit - 3) * std::numbers::pi / 180);
    const double limit = std::cos(std::min(p.slant_limit + 3, 90.0) * std::numbers::pi / 180);
    // Half up by truncation of a positive number: the library's rounding costs more than all the rest here.
    constexpr int shift = 64;
    const auto moved = [&](int at, double by, int size) {
        return std::clamp(static_cast<int>(at + by + (shift + 0.5)) - shift, 0, size - 1);
    };
    out.resize(width, height);
    for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u) {
            const size_t at = static_cast<size_t>(v) * width + u;
            uint16_t& pixel = out.millimetres[at];
            pixel = 0;
            const uint64_t counter = 4 * at;
            const int from_u = moved(u, jitter * random.normal(counter), width);
            const int from_v = moved(v, jitter * random.normal(counter + 1), height);
            const size_t i = static_cast<size_t>(from_v) * width + from_u;
            const float z = layer.z[i], cosine = layer.cosine[i];
            if (layer.shaded[i] != 0 || !(z >= p.nearest && z <= p.farthest)) continue;
            const double chance = random.uniform(counter + 2);
            if (chance < p.speckle * p.level) continue;
            if (cosine < steepest && cosine < limit + (steepest - limit) * chance) continue;
            const double noise =
                p.level > 0 ? p.level * steps_of_noise(z, cosine) * random.normal(counter + 3) : 0;
            const auto disparity = static_cast<int>(per_metre / z + noise + 0.5);
            if (disparity < 1) continue;
            const double seen = per_metre / disparity;
            if (seen < p.nearest || seen > p.farthest) continue;
            pixel = static_cast<uint16_t>(1000 * seen + 0.5);
        }
}

}  // namespace deixis
