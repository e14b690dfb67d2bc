// The loop that drains the rings into the session. In: frames of each sensor; out: appended streams.
#include "appliance/commands/live_recording.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "appliance/sensors/host_clock.h"

namespace deixis {
namespace {

using std::chrono::milliseconds;

constexpr int ring_frames = 48;             ///< 1.6 s of a slow disk
constexpr int64_t settling_us = 1'000'000;  ///< until the least delay of a stream has been seen

FrameSourceParams source_params(const LiveRecordingParams& params) {
    FrameSourceParams source;
    source.program = params.program;
    source.driver_folder = params.driver_folder;
    source.ring_frames = ring_frames;
    source.live_backlog = ring_frames - 2;
    return source;
}

}  // namespace

Result<LiveRecording> LiveRecording::start(const SensorRig& rig, const LiveRecordingParams& params,
                                           const std::function<bool()>& stop) {
    LiveRecording recording;
    recording.params_ = params;
    for (const CalibratedSensor& sensor : rig.sensors) {
        if (sensor.kind != SensorKind::depth)
            return fail("sensor \"" + sensor.name +
                        "\" is not a depth sensor, only those can be recorded live");
        if (sensor.uri.empty())
            return fail("sensor \"" + sensor.name +
                        "\" has no uri in the calibration, expected its live device");
        SensorSpec spec;
        spec.name = sensor.name;
        spec.uri = sensor.uri;
        spec.width = sensor.camera.width;
        spec.height = sensor.camera.height;
        recording.sensors_.emplace_back(spec, source_params(params));
    }
    remove_left_over_rings();
    recording.streams_.resize(recording.sensors_.size());

    const int64_t deadline = host_now_us() + static_cast<int64_t>(params.wait_seconds * 1e6);
    std::vector<int64_t> first_us(recording.sensors_.size(), 0);
    for (;;) {
        bool settled = true;
        for (size_t i = 0; i < recording.sensors_.size(); ++i) {
            SupervisedSensor& sensor = recording.sensors_[i];
            sensor.watch();
            while (sensor.take(recording.frame_))
                if (first_us[i] == 0) first_us[i] = host_now_us();
            if (!sensor.is_running()) first_us[i] = 0;
            settled = settled && first_us[i] != 0 && host_now_us() - first_us[i] >= settling_us;
        }
        if (settled) return recording;
        if (stop()) return fail("stopped before every sensor was running");
        if (host_now_us() > deadline) break;
        wait_for_bell(recording.sensors_, milliseconds(20));
    }
    std::string absent;
    for (const SupervisedSensor& sensor : recording.sensors_)
        if (!sensor.is_running())
            absent += (absent.empty() ? "sensor \"" : "; sensor \"") + sensor.spec().name + "\" is " +
                      name_of(sensor.health().state) + ": " + sensor.health().reason;
    if (!absent.empty()) return fail(absent);
    return fail("the sensors did not run together for a second");
}

Result<void> LiveRecording::run(SessionWriter& writer, const std::function<bool()>& stop, const Say& say) {
    zero_us_ = host_now_us();
    for (size_t i = 0; i < sensors_.size(); ++i) {
        streams_[i].offset_us = sensors_[i].health().clock_offset_us - zero_us_;
        streams_[i].restarts = sensors_[i].health().restarts;
    }
    const int64_t end =
        params_.seconds > 0 ? zero_us_ + static_cast<int64_t>(params_.seconds * 1e6) : INT64_MAX;
    bool last_round = false;
    while (!last_round) {
        last_round = stop() || host_now_us() >= end;  // what is in the rings by then still belongs to it
        for (size_t i = 0; i < sensors_.size(); ++i) {
            sensors_[i].watch();
            while (sensors_[i].take(frame_))
                if (auto done = write_frame(writer, i); !done) return done;
            report(i, say);
        }
        if (!last_round) wait_for_bell(sensors_, milliseconds(20));
    }
    return {};
}

Result<void> LiveRecording::write_frame(SessionWriter& writer, size_t i) {
    Stream& stream = streams_[i];
    const SensorHealth& health = sensors_[i].health();
    if (health.restarts != stream.restarts) {
        // The device may have begun its clock anew.
        stream.restarts = health.restarts;
        stream.offset_us = health.clock_offset_us - zero_us_;
    }
    const int64_t timestamp_us = frame_.sensor_time_us + stream.offset_us;
    if (timestamp_us < 0 || timestamp_us <= stream.last_us) return {};
    stream.last_us = timestamp_us;
    ++stream.frames;
    return writer.append(i, timestamp_us, frame_.frame.depth,
                         std::max<int64_t>(1, frame_.frame.host_us - zero_us_));
}

void LiveRecording::report(size_t i, const Say& say) {
    const SensorHealth& health = sensors_[i].health();
    if (health.state == streams_[i].state) return;
    streams_[i].state = health.state;
    say("sensor \"" + health.name + "\" is " + name_of(health.state) +
        (health.reason.empty() ? std::string() : ": " + health.reason));
}

std::vector<RecordedSensor> LiveRecording::sensors() const {
    std::vector<RecordedSensor> recorded;
    recorded.reserve(sensors_.size());
    for (size_t i = 0; i < sensors_.size(); ++i)
        recorded.push_back({sensors_[i].spec().name, streams_[i].frames, sensors_[i].health()});
    return recorded;
}

}  // namespace deixis
