// One sensor of the station: its child kept alive, its frames in order, its state. Frames out, never an
// exception.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "appliance/sensors/child_process.h"
#include "appliance/sensors/clock_offset.h"
#include "appliance/sensors/frame_ring.h"
#include "appliance/sensors/frame_source.h"

namespace deixis {

/// Frame of one sensor as it came.
struct SensorFrame {
    DepthFrame frame;            ///< stamp on the session clock
    int64_t sensor_time_us = 0;  ///< as the sensor or file gave it
};

/// Starts `deixis sensor`, ends it when it dies, hangs or talks nonsense, and starts it again: after
/// `restart_delay`, twice as long each time that no frame came in between, at most 8 s. A restarted recording
/// goes on where it was; a recording that cannot be played, or fails 5 times without a frame, is given up.
class SupervisedSensor {
  public:
    SupervisedSensor(SensorSpec spec, const FrameSourceParams& params);
    ~SupervisedSensor();
    SupervisedSensor(SupervisedSensor&&) noexcept;

    /// Looks after the child; to be called every 50 ms or so. Never waits.
    void watch();

    /// The next frame, if one is there. In lock-step every frame of the recording, in order, once.
    bool take(SensorFrame& out);

    /// No frame will come any more: recording delivered or given up.
    bool is_over() const { return finished_ || given_up_; }
    bool is_alive() { return child_.has_value() && !child_->ended(); }
    bool is_running() const { return state_ == SensorState::running; }
    /// Has its first frame or has failed to; paced recordings wait for each other at the start.
    bool has_settled() const;
    void play_at(int64_t host_us);

    void ask_to_end();
    const SensorHealth& health() const { return health_; }
    void note_skew(int64_t skew_us) { health_.skew_us = skew_us; }
    void count_dropped() { ++dropped_by_station_; }
    const SensorSpec& spec() const { return spec_; }
    int bell() const;  ///< file to poll; -1 = none
    void hush();

  private:
    void start();
    void watch_child();
    void judge_end(const std::string& end);
    void end_child(SensorState state, std::string reason);
    void accept(SensorFrame& out);
    void publish_health();

    SensorSpec spec_;
    FrameSourceParams params_;
    std::optional<FrameRingReader> ring_;
    std::optional<ChildProcess> child_;
    ClockOffset clock_;
    SensorHealth health_;
    SensorState state_ = SensorState::starting;
    std::string reason_;
    bool finished_ = false, given_up_ = false, settled_ = false;
    int failures_ = 0;  ///< ends of the child since the last frame
    int refused_in_a_row_ = 0;
    int64_t start_after_us_ = 0;  ///< host clock
    int64_t play_at_us_ = 0;
    int64_t last_arrival_us_ = -1;
    int64_t last_stamp_us_ = INT64_MIN;
    uint64_t delivered_ = 0;       ///< frames of the recording that need not come again
    uint64_t dropped_before_ = 0;  ///< by the rings of earlier children
    uint64_t dropped_by_station_ = 0;
};

/// Sleeps until a bell rings, but not longer than `patience`.
void wait_for_bell(std::vector<SupervisedSensor>& sensors, std::chrono::milliseconds patience);

/// Asks all children to close their devices and waits at most a second, all at once; who is left is killed.
void end_in_order(std::vector<SupervisedSensor>& sensors);

}  // namespace deixis
