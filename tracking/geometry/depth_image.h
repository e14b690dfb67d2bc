// Depth images and the frameset: what the sensors hand to the stages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace deixis {

/// Row-major millimetres along the optical axis (z, not range); 0 = no measurement, 1-65534 valid.
struct DepthImage {
    int width = 0;
    int height = 0;
    std::vector<uint16_t> millimetres;

    uint16_t at(int u, int v) const { return millimetres[static_cast<size_t>(v) * width + u]; }
    void resize(int w, int h) {
        width = w;
        height = h;
        millimetres.resize(static_cast<size_t>(w) * h);
    }
};

/// One sensor's frame on the session clock. Buffers are reused: `present == false` means no image of this
/// moment, whatever is in it.
struct DepthFrame {
    bool present = false;
    int64_t timestamp_us = 0;
    int64_t host_us = 0;  ///< arrival on this machine; 0 = unknown
    DepthImage depth;
};

/// One frame of the first sensor with the nearest of each other within 17 ms (`present` false beyond that),
/// in the order of the depth sensors of the calibration. `timestamp_us` is the first sensor's. A frame that
/// is not present may hold the sensor's nearest one all the same, with its stamp: see FrameGaps.
struct Frameset {
    int64_t timestamp_us = 0;
    std::vector<DepthFrame> frames;
};

}  // namespace deixis
