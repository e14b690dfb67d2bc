// Pixels that tell which frame they are, for tests of everything that hands frames on.
#pragma once

#include <cstdint>
#include <vector>

#include "tracking/geometry/depth_image.h"

namespace deixis::test {

/// Frame `n` of sensor `sensor`: every pixel depends on both, none is 65535.
inline DepthImage numbered_image(int width, int height, uint32_t n, uint32_t sensor = 0) {
    DepthImage image;
    image.resize(width, height);
    uint32_t state = n * 2654435761U + sensor * 40503U + 1;
    for (size_t i = 0; i < image.millimetres.size(); ++i) {
        if (i % 17 == 0) state = state * 1664525U + 1013904223U;
        image.millimetres[i] = static_cast<uint16_t>((500 + (state >> 20) + i % 7) % 9000);
    }
    image.millimetres[0] = static_cast<uint16_t>(n);
    return image;
}

}  // namespace deixis::test
