// How far a sensor's clock is from the host's, from the stamps of its frames and their arrival.
#pragma once

#include <cstdint>

namespace deixis {

/// Minimum-delay filter: of all frames of the last 5 to 10 seconds the one that travelled fastest tells the
/// offset; the others only arrived late. Two windows of 5 s, so that drift is followed. A jump of more than a
/// second (the device started anew) begins afresh.
class ClockOffset {
  public:
    /// A frame stamped `timestamp_us` by the sensor arrived at `host_us`. Returns the host clock minus the
    /// sensor clock [us], plus the (unknowable) shortest delay.
    int64_t update(int64_t timestamp_us, int64_t host_us);

    int64_t offset_us() const { return offset_us_; }

  private:
    bool started_ = false;
    int64_t window_begin_us_ = 0;
    int64_t current_us_ = 0, previous_us_ = 0;  ///< least difference of this window and of the one before
    int64_t offset_us_ = 0;
};

}  // namespace deixis
