// The minimum-delay filter. In: stamp and arrival of each frame; out: the offset of the clocks.
#include "appliance/sensors/clock_offset.h"

#include <algorithm>
#include <cstdlib>

namespace deixis {
namespace {
constexpr int64_t window_us = 5'000'000;
constexpr int64_t jump_us = 1'000'000;
}  // namespace

int64_t ClockOffset::update(int64_t timestamp_us, int64_t host_us) {
    const int64_t difference = host_us - timestamp_us;
    if (!started_ || std::abs(difference - offset_us_) > jump_us) {
        started_ = true;
        window_begin_us_ = host_us;
        current_us_ = previous_us_ = difference;
    } else if (host_us - window_begin_us_ > window_us) {
        window_begin_us_ = host_us;
        previous_us_ = current_us_;
        current_us_ = difference;
    } else {
        current_us_ = std::min(current_us_, difference);
    }
    offset_us_ = std::min(current_us_, previous_us_);
    return offset_us_;
}

}  // namespace deixis
