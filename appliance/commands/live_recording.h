// Live depth sensors into a session, each stream as its sensor gave it. Sensor processes in, session folder
// out.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "appliance/sensors/supervised_sensor.h"
#include "appliance/sessions/session_writer.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

struct LiveRecordingParams {
    std::filesystem::path program;        ///< whose `sensor` subcommand is started
    std::filesystem::path driver_folder;  ///< private OpenNI2 folder; empty: the system's
    double seconds = 0;                   ///< to record; 0 = until `stop`
    double wait_seconds = 20;             ///< at most, until every sensor runs
};

/// What became of one sensor.
struct RecordedSensor {
    std::string name;
    int64_t frames = 0;
    SensorHealth health;
};

/// Starts the sensors, waits until each has run for a second (then the offset of its clock is known and
/// kept), and writes every frame from then on, unpaired, bit for bit, with its own stamp shifted onto the
/// session clock and its arrival. The session clock begins with the recording. A sensor that goes away is
/// waited for while the others go on; `say` gets a sentence for each loss and return. Only depth sensors with
/// a uri can be recorded. Refuses a sensor that does not come up, naming its reason; after a refusal in the
/// middle (full disk) the frames before are kept.
class LiveRecording {
  public:
    using Say = std::function<void(const std::string&)>;
    static Result<LiveRecording> start(const SensorRig& rig, const LiveRecordingParams& params,
                                       const std::function<bool()>& stop);
    Result<void> run(SessionWriter& writer, const std::function<bool()>& stop, const Say& say);
    std::vector<RecordedSensor> sensors() const;
    void end() { end_in_order(sensors_); }

  private:
    struct Stream {
        int64_t offset_us = 0;  ///< session clock minus sensor clock, fixed while the child lives
        int64_t last_us = -1;
        int64_t frames = 0;
        uint64_t restarts = 0;
        SensorState state = SensorState::running;
    };
    Result<void> write_frame(SessionWriter& writer, size_t i);
    void report(size_t i, const Say& say);

    LiveRecordingParams params_;
    std::vector<SupervisedSensor> sensors_;
    std::vector<Stream> streams_;
    SensorFrame frame_;
    int64_t zero_us_ = 0;  ///< host clock at the session's zero
};

}  // namespace deixis
