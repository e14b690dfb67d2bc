// The station's one way to get framesets, live or replayed, from `deixis sensor` children.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"

namespace deixis {

enum class SensorState { starting, running, stalled, restarting, missing, finished };

/// "starting", "running", "stalled", "restarting", "missing" or "finished".
const char* name_of(SensorState state);

/// One sensor as the station publishes it.
struct SensorHealth {
    std::string name;
    SensorState state = SensorState::starting;
    std::string reason;         ///< one sentence when not running
    uint64_t frames = 0;        ///< taken by the station
    uint64_t dropped = 0;       ///< overwritten in the ring before the station took them (always 0 in lock-step)
    uint64_t corrupt = 0;       ///< refused by checksum or header
    uint64_t restarts = 0;
    int64_t age_us = -1;        ///< since the last frame arrived; -1 = none yet
};

/// Where one depth stream comes from.
struct SensorSpec {
    std::string name;
    std::string uri;              ///< live device, or path of an .oni file
    bool recording = false;       ///< `uri` is an .oni file
    int64_t start_us = 0;         ///< added to a recording's stamps
    int64_t frames = -1;          ///< expected frames of a recording; -1 = unknown
    int width = 0, height = 0;    ///< from the calibration; another size is refused
};

class FrameSource {
  public:
    enum class Outcome { frameset, timeout, end };
    virtual ~FrameSource() = default;
    /// Waits at most `patience` for the next frameset and copies it into `out` (buffers reused).
    /// `timeout`: nothing in time, `health()` says what is missing. `end`: every recording has been delivered.
    virtual Outcome next(Frameset& out, std::chrono::milliseconds patience) = 0;
    virtual std::vector<SensorHealth> health() const = 0;
};

struct FrameSourceParams {
    bool lock_step = false;              ///< replay: children wait for the station, nothing is dropped
    bool real_time = false;              ///< play recordings at their own pace (demo, live test)
    int64_t pairing_window_us = 17'000;  ///< formats.md
    std::chrono::milliseconds stall_limit{1'000};   ///< no heartbeat for so long: the child is ended
    std::chrono::milliseconds pair_patience{40};    ///< live: wait for the other sensor's frame
    std::chrono::milliseconds restart_delay{500};   ///< grows twofold to 8 s while starts fail
    std::filesystem::path program;       ///< the `deixis` binary whose `sensor` subcommand is started
    InvalidSettings validate() const;
};

/// Starts one child a sensor. Never fails for a missing device: that is a state.
Result<std::unique_ptr<FrameSource>> open_sensors(const std::vector<SensorSpec>& sensors,
                                                  const FrameSourceParams& params);

}  // namespace deixis
