// Depth images for tests, by kind and seed.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "tracking/geometry/depth_image.h"

namespace deixis::testing {

/// A sloping wall with a box before it, disparity steps, noise and holes: about what a structured-light
/// sensor gives.
inline DepthImage room_image(int width, int height, uint32_t seed) {
    std::mt19937 random(seed);
    DepthImage image;
    image.resize(width, height);
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
            double z = 2500.0 + 2.0 * u + 1.0 * v;
            const bool box = u > width / 3 && u < width / 2 && v > height / 4 && v < 3 * height / 4;
            if (box) z = 1400.0 + static_cast<double>(seed % 100);
            const double step = 2.85e-6 * z * z;
            z = step * static_cast<double>(static_cast<int>(z / step) + static_cast<int>(random() % 3));
            const bool hole = random() % 50 == 0;
            image.millimetres[static_cast<size_t>(v) * width + u] =
                hole ? uint16_t{0} : static_cast<uint16_t>(z);
        }
    }
    return image;
}

/// Independent values from 0 to `largest`.
inline DepthImage noise_image(int width, int height, uint32_t seed, uint16_t largest) {
    std::mt19937 random(seed);
    DepthImage image;
    image.resize(width, height);
    for (uint16_t& value : image.millimetres) value = static_cast<uint16_t>(random() % (largest + 1U));
    return image;
}

inline DepthImage flat_image(int width, int height, uint16_t value) {
    DepthImage image;
    image.resize(width, height);
    for (uint16_t& pixel : image.millimetres) pixel = value;
    return image;
}

}  // namespace deixis::testing
