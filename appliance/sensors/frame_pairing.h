// Framesets out of the frames of several sensors: the nearest of each other sensor to every frame of one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tracking/geometry/depth_image.h"

namespace deixis {

/// Holds the frames of each sensor in order until a frameset has used or passed them. Pure: no clock, no
/// waiting; who calls decides when to wait. Buffers go round, nothing is allocated once the queues have
/// grown.
class FramePairing {
  public:
    /// `window_us`: a frame further away than this is no partner (exactly this far still is).
    FramePairing(size_t sensors, int64_t window_us);

    /// Queues a frame, stamps of a sensor not falling; `frame` gets a used buffer in exchange.
    void put(size_t sensor, DepthFrame& frame);

    size_t waiting(size_t sensor) const { return lanes_[sensor].count; }
    const DepthFrame& front(size_t sensor) const { return lanes_[sensor].at(0); }
    void drop_front(size_t sensor);

    /// True when no later frame of `sensor` can be nearer to `timestamp_us` than those queued.
    bool has_passed(size_t sensor, int64_t timestamp_us) const;

    /// False when the next frame of `sensor`, a `period_us` after its newest, will be no nearer to
    /// `timestamp_us` than that one.
    bool may_come_nearer(size_t sensor, int64_t timestamp_us, int64_t period_us) const;

    /// Forgets the frames of `sensor` that are no partner for `timestamp_us` or anything later.
    void forget_before(size_t sensor, int64_t timestamp_us);

    /// Takes the front frame of `clock` and copies it with the nearest of every other sensor (of two equally
    /// near the earlier) into `out`; its stamp is the frameset's. A nearest frame beyond the window goes
    /// along, not present.
    void take(size_t clock, Frameset& out);

    /// The same for a moment that is no frame's: the nearest of every sensor. Nothing is dropped.
    void take_at(int64_t timestamp_us, Frameset& out);

  private:
    struct Lane {
        std::vector<DepthFrame> slots;
        size_t first = 0, count = 0;
        const DepthFrame& at(size_t i) const { return slots[(first + i) % slots.size()]; }
        DepthFrame& at(size_t i) { return slots[(first + i) % slots.size()]; }
    };
    void copy_nearest(const Lane& lane, int64_t timestamp_us, DepthFrame& out) const;

    std::vector<Lane> lanes_;
    int64_t window_us_;
};

}  // namespace deixis
