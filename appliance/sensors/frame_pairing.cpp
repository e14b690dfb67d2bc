// Pairing by the nearest stamp. In: frames sensor by sensor; out: framesets.
#include "appliance/sensors/frame_pairing.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace deixis {
namespace {

constexpr int64_t kept_us = 100'000;  // a frame older than this fills no gap

}  // namespace

FramePairing::FramePairing(size_t sensors, int64_t window_us) : lanes_(sensors), window_us_(window_us) {}

void FramePairing::put(size_t sensor, DepthFrame& frame) {
    Lane& lane = lanes_[sensor];
    if (lane.count == lane.slots.size()) {
        std::rotate(lane.slots.begin(), lane.slots.begin() + static_cast<ptrdiff_t>(lane.first),
                    lane.slots.end());
        lane.first = 0;
        lane.slots.resize(std::max<size_t>(4, 2 * lane.count));
    }
    std::swap(lane.at(lane.count++), frame);
}

void FramePairing::drop_front(size_t sensor) {
    Lane& lane = lanes_[sensor];
    lane.first = (lane.first + 1) % lane.slots.size();
    --lane.count;
}

bool FramePairing::has_passed(size_t sensor, int64_t timestamp_us) const {
    const Lane& lane = lanes_[sensor];
    return lane.count > 0 && lane.at(lane.count - 1).timestamp_us >= timestamp_us;
}

void FramePairing::forget_before(size_t sensor, int64_t timestamp_us) {
    Lane& lane = lanes_[sensor];
    while (lane.count >= 2 && lane.at(1).timestamp_us <= timestamp_us) drop_front(sensor);
    while (lane.count >= 1 && lane.at(0).timestamp_us < timestamp_us - std::max(window_us_, kept_us))
        drop_front(sensor);
}

void FramePairing::take(size_t clock, Frameset& out) {
    out.timestamp_us = front(clock).timestamp_us;
    out.frames.resize(lanes_.size());
    for (size_t s = 0; s < lanes_.size(); ++s) {
        if (s != clock) forget_before(s, out.timestamp_us);
        const Lane& lane = lanes_[s];
        const DepthFrame* nearest = lane.count > 0 ? &lane.at(0) : nullptr;
        if (s != clock && lane.count > 1 &&
            std::abs(lane.at(1).timestamp_us - out.timestamp_us) <
                std::abs(nearest->timestamp_us - out.timestamp_us))
            nearest = &lane.at(1);
        if (nearest == nullptr) {
            out.frames[s].present = false;
            out.frames[s].depth.millimetres.clear();
            continue;
        }
        out.frames[s] = *nearest;
        out.frames[s].present = std::abs(nearest->timestamp_us - out.timestamp_us) <= window_us_;
    }
    drop_front(clock);
}

}  // namespace deixis
