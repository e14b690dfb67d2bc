// `deixis sensor`: the process that owns one OpenNI2 device or recording, started by the station.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <thread>

#include "appliance/commands/commands.h"
#include "appliance/sensors/frame_ring.h"
#include "appliance/sensors/sensor_child.h"
#include "appliance/sessions/oni_walker.h"

namespace deixis {
namespace {

struct SensorOptions {
    std::string ring;
    std::string recording;
    std::string uri;
    uint64_t skip = 0;
    int bell = -1;
    bool paced = false;
    bool quiet = false;
};

/// Heartbeats while the main thread walks a long recording, before OpenNI2 is touched.
class BeatMeanwhile {
  public:
    explicit BeatMeanwhile(FrameRingWriter& ring)
        : thread_([this, &ring](const std::stop_token& stop) {
              std::unique_lock lock(mutex_);
              while (!wake_.wait_for(lock, stop, std::chrono::milliseconds(100), [] { return false; }) &&
                     !stop.stop_requested())
                  ring.beat();
          }) {}

  private:
    std::mutex mutex_;
    std::condition_variable_any wake_;
    std::jthread thread_;
};

/// Whatever OpenNI2 cannot play whole is refused before OpenNI2 sees it.
Result<int64_t> count_frames(const SensorOptions& options, FrameRingWriter& ring) {
    std::error_code error;
    const auto type = std::filesystem::status(options.recording, error).type();
    if (type == std::filesystem::file_type::not_found) return fail(options.recording + ": does not exist");
    if (type != std::filesystem::file_type::regular)
        return fail(options.recording + ": is not a file, expected an OpenNI2 recording");
    const BeatMeanwhile beating(ring);
    const auto summary = walk_oni(options.recording);
    if (!summary) return fail(summary.error().sentence);
    const RingGeometry size = ring.geometry();
    if (summary->infrared) return fail(options.recording + ": is an infrared recording, expected depth");
    if (summary->width != size.width || summary->height != size.height)
        return fail(options.recording + ": is " + std::to_string(summary->width) + "x" +
                    std::to_string(summary->height) + ", expected " + std::to_string(size.width) + "x" +
                    std::to_string(size.height));
    return summary->frames;
}

Result<void> run_sensor(const SensorOptions& options) {
    follow_parent();
    auto ring = FrameRingWriter::attach(options.ring);
    if (!ring) return fail(ring.error().sentence);
    SensorChildParams params;
    params.recording = !options.recording.empty();
    params.uri = params.recording ? options.recording : options.uri;
    params.skip = options.skip;
    params.paced = options.paced;
    params.bell = options.bell;
    if (params.recording) {
        const auto frames = count_frames(options, *ring);
        if (!frames) {
            ring->say(RingState::refused, frames.error().sentence);
            return fail(frames.error().sentence);
        }
        params.frames = *frames;
    }
    return run_sensor_child(*ring, params);
}

}  // namespace

void add_sensor_command(CLI::App& app) {
    static SensorOptions options;
    CLI::App* sensor = app.add_subcommand(
        "sensor", "Hand the frames of one OpenNI2 device or recording to the station (which starts this)");
    sensor->add_option("--ring", options.ring, "frame ring in shared memory, made by the station")
        ->required();
    auto* uri = sensor->add_option("--uri", options.uri, "live device; \"any\": the first there is");
    auto* recording =
        sensor->add_option("--recording", options.recording, "recording (.oni) to play")->excludes(uri);
    sensor->add_option("--skip", options.skip, "frames of the recording not to send again")->needs(recording);
    sensor->add_flag("--paced", options.paced, "play the recording at its own pace")->needs(recording);
    sensor->add_option("--bell", options.bell, "open file that gets a byte after each frame");
    sensor->add_flag("--quiet", options.quiet, "say what is wrong in the ring only");
    sensor->callback([] {
        const auto done = run_sensor(options);
        if (!done && !options.quiet) std::cerr << done.error().sentence << '\n';
        std::cerr.flush();
        // No destructors of OpenNI2's drivers: some take half a second, some never return.
        std::_Exit(done ? 0 : 1);
    });
}

}  // namespace deixis
