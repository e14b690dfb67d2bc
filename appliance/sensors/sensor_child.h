// What the process `deixis sensor` does after its file was found sound: frames from OpenNI2 into a ring.
#pragma once

#include <cstdint>
#include <string>

#include "appliance/sensors/frame_ring.h"

namespace deixis {

struct SensorChildParams {
    std::string uri;  ///< device ("" or "any": the first there is), or path of a recording
    bool recording = false;
    int64_t frames = 0;  ///< of the recording, as its records were counted
    uint64_t skip = 0;   ///< of the recording: frames that the station already has
    bool paced =
        false;      ///< a recording at its own pace from `play_at_us` on, else as fast as the ring takes it
    int bell = -1;  ///< file to ring after each frame; -1 = none
};

/// From here on SIGTERM ends the child in order, and the end of the process that started it ends it at once,
/// whatever it hangs in.
void follow_parent();

/// True once SIGTERM came.
bool asked_to_end();

/// Delivers frames until the recording ends, the device is lost or someone asks to end. One thread; every
/// wait is at most 100 ms and leaves a heartbeat. Says state and sentence in the ring. Returns the sentence
/// of a failure.
Result<void> run_sensor_child(FrameRingWriter& ring, const SensorChildParams& params);

}  // namespace deixis
