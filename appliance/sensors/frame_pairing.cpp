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

bool FramePairing::may_come_nearer(size_t sensor, int64_t timestamp_us, int64_t period_us) const {
    const Lane& lane = lanes_[sensor];
    return lane.count == 0 || 2 * (timestamp_us - lane.at(lane.count - 1).timestamp_us) > period_us;
}

void FramePairing::forget_before(size_t sensor, int64_t timestamp_us) {
    Lane& lane = lanes_[sensor];
    while (lane.count >= 2 && lane.at(1).timestamp_us <= timestamp_us) drop_front(sensor);
    while (lane.count >= 1 && lane.at(0).timestamp_us < timestamp_us - std::max(window_us_, kept_us))
        drop_front(sensor);
}

void FramePairing::copy_nearest(const Lane& lane, int64_t timestamp_us, DepthFrame& out) const {
    if (lane.count == 0) {
        out.present = false;
        out.depth.millimetres.clear();
        return;
    }
    const auto distance = [&](size_t i) { return std::abs(lane.at(i).timestamp_us - timestamp_us); };
    const size_t nearest = lane.count > 1 && distance(1) < distance(0) ? 1 : 0;
    out = lane.at(nearest);
    out.present = distance(nearest) <= window_us_;
}

void FramePairing::take(size_t clock, Frameset& out) {
    out.timestamp_us = front(clock).timestamp_us;
    out.frames.resize(lanes_.size());
    for (size_t s = 0; s < lanes_.size(); ++s) {
        if (s == clock) {
            out.frames[s] = front(clock);
            out.frames[s].present = true;
        } else {
            forget_before(s, out.timestamp_us);
            copy_nearest(lanes_[s], out.timestamp_us, out.frames[s]);
        }
    }
    drop_front(clock);
}

void FramePairing::take_at(int64_t timestamp_us, Frameset& out) {
    out.timestamp_us = timestamp_us;
    out.frames.resize(lanes_.size());
    for (size_t s = 0; s < lanes_.size(); ++s) {
        forget_before(s, timestamp_us);
        copy_nearest(lanes_[s], timestamp_us, out.frames[s]);
    }
}

}  // namespace deixis
