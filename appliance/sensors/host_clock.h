// The host's steady clock as all processes of this machine see it.
#pragma once

#include <chrono>
#include <cstdint>

namespace deixis {

/// Microseconds of CLOCK_MONOTONIC: the same in the station and in its children, never set back.
inline int64_t host_now_us() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

}  // namespace deixis
