// What the station says of itself besides the frame: sensors, record, PLC, progress; and the message for the
// screen.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "appliance/plc/plc_link.h"
#include "appliance/records/mark_recorder.h"
#include "appliance/sensors/frame_source.h"
#include "appliance/station/frame_result.h"

namespace deixis {

struct StationState {
    std::string source;  ///< "live" or the session's name
    std::vector<SensorHealth> sensors;
    RecorderState record;
    LinkState plc;
    std::string plc_said;      ///< newest of what the link noted: requests that were refused, and why
    int64_t framesets = 0;     ///< seen so far
    int64_t expected = -1;     ///< of the session; -1 = live
    bool finished = false;     ///< the session has been played to its end
    int64_t marks_total = 0;   ///< committed since start
    int64_t marks_lost = 0;    ///< seen and not to be recorded
    std::string last_trouble;  ///< newest refusal (a mark that could not be recorded...), empty when none
};

/// True when every sensor delivers.
bool sensors_ok(const StationState& state);

/// One object of the live stream: `{"frame": results line or null, "sensors": [...], "plc", "record",
/// "session", "progress", "finished", "marks_total", "trouble", "stale_after_ms"}`. `frame` null means
/// nothing is known now.
nlohmann::ordered_json live_message(const StationState& state, const FrameResult* frame);

}  // namespace deixis
