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
    std::string reason;    ///< one sentence when not running
    uint64_t frames = 0;   ///< taken by the station
    uint64_t dropped = 0;  ///< overwritten in the ring before the station took them (always 0 in lock-step)
    uint64_t corrupt = 0;  ///< refused by checksum or header
    uint64_t restarts = 0;
    int64_t age_us = -1;          ///< since the last frame arrived; -1 = none yet
    int process_id = 0;           ///< of the running child; 0 = none
    int64_t clock_offset_us = 0;  ///< live: session (host) clock minus sensor clock as now estimated
    int64_t skew_us = 0;          ///< stamp of its frame minus the frameset's, in the last one that held it
};

/// Where one depth stream comes from.
struct SensorSpec {
    std::string name;
    std::string uri;            ///< live device, or path of an .oni file
    bool recording = false;     ///< `uri` is an .oni file
    int64_t start_us = 0;       ///< added to a recording's stamps
    int64_t frames = -1;        ///< expected frames of a recording; -1 = unknown
    int width = 0, height = 0;  ///< from the calibration; another size is refused
};

class FrameSource {
  public:
    enum class Outcome { frameset, timeout, end };
    virtual ~FrameSource() = default;
    /// Waits at most `patience` for the next frameset and copies it into `out` (buffers reused).
    /// `timeout`: nothing in time, `health()` says what is missing. `end`: every recording has been
    /// delivered.
    virtual Outcome next(Frameset& out, std::chrono::milliseconds patience) = 0;
    virtual std::vector<SensorHealth> health() const = 0;
};

struct FrameSourceParams {
    bool lock_step = false;  ///< replay: children wait for the station, nothing is dropped
    bool real_time = false;  ///< play recordings at their own pace; with lock_step nothing is dropped either
    int64_t pairing_window_us = 17'000;             ///< formats.md
    std::chrono::milliseconds stall_limit{1'000};   ///< no heartbeat for so long: the child is ended
    std::chrono::milliseconds pair_patience{40};    ///< live: wait for the other sensor's frame
    std::chrono::milliseconds restart_delay{500};   ///< grows twofold to 8 s while starts fail
    std::chrono::milliseconds start_limit{15'000};  ///< stall limit while the child opens its device or file
    std::chrono::milliseconds silence_limit{200};   ///< live: a sensor silent for so long is not waited for
    int ring_frames = 8;                            ///< slots of each ring, 2 to 256
    int live_backlog = 3;  ///< live: framesets that may wait for the station; older ones are dropped
    /// Lock-step: stamps of the framesets, where a stream without depth clocks them; empty: those of the
    /// first sensor.
    std::vector<int64_t> clock_us;
    std::filesystem::path program;        ///< the `deixis` binary whose `sensor` subcommand is started
    std::filesystem::path driver_folder;  ///< holds libOpenNI2.so.0 and OpenNI2/Drivers; empty: the system's
    InvalidSettings validate() const;
};

/// Starts one child a sensor; its own left-over rings of killed runs are removed first. Never fails for a
/// missing device or a bad file: that is a state (`missing`, with the child's sentence as the reason).
/// Refused, naming the sensor or key: no sensor, a size outside 1 to 8192, an invalid parameter, a live
/// device in lock_step.
///
/// Lock-step: one frameset for every frame of the first sensor (or stamp of `clock_us`), stamps and pixels
/// exact, the same on every run and whatever happens to the children; `end` as well when the first sensor's
/// recording cannot be read (see `health`). Live: stamps are each sensor's own clock mapped to the host's
/// steady clock, strictly rising; newest frames win; without the first sensor the next one that runs clocks
/// the framesets (first frame not `present`). A recording that is not in lock_step is played at its own pace.
/// The source belongs to one thread; only `health` may be called from others.
Result<std::unique_ptr<FrameSource>> open_sensors(const std::vector<SensorSpec>& sensors,
                                                  const FrameSourceParams& params);

}  // namespace deixis
