// The loop of one sensor process. In: OpenNI2 frames; out: ring slots, heartbeats, one sentence at the end.
#include "appliance/sensors/sensor_child.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "appliance/sensors/host_clock.h"
#include "appliance/sensors/openni_reader.h"

namespace deixis {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds longest_wait{100};
constexpr int64_t longest_silence_us = 5'000'000;  ///< then the device or file is opened anew
constexpr int64_t too_late_us = 100'000;           ///< paced without lock-step: later than this is not shown

volatile sig_atomic_t end_requested = 0;
pid_t parent = 0;

void on_end(int) {
    end_requested = 1;
}

void on_parent_thread_ended(int) {
    // The signal comes when the thread that started us ends; the station itself may live on.
    if (getppid() != parent) _exit(0);
}

class SensorLoop {
  public:
    SensorLoop(FrameRingWriter& ring, const SensorChildParams& params) : ring_(ring), params_(params) {}
    Result<void> play_recording();
    Result<void> follow_device();

  private:
    bool must_end() const { return asked_to_end() || getppid() != parent; }
    bool rest(milliseconds t);
    bool wait_until_due(int64_t timestamp_us, bool& too_late);
    bool wait_for_slot();
    void deliver(uint64_t frame_id);
    Result<void> lose(std::string sentence);
    Result<void> refuse(std::string sentence);

    FrameRingWriter& ring_;
    const SensorChildParams& params_;
    OpenniFrame frame_;
    bool running_ = false;
};

/// Between two tries of a device that is not there: nothing announces when it is. False when it is time to
/// end.
bool SensorLoop::rest(milliseconds t) {
    std::this_thread::sleep_for(t);
    ring_.beat();
    return !must_end();
}

Result<void> SensorLoop::lose(std::string sentence) {
    ring_.say(RingState::lost, sentence);
    return fail(std::move(sentence));
}

Result<void> SensorLoop::refuse(std::string sentence) {
    ring_.say(RingState::refused, sentence);
    return fail(std::move(sentence));
}

bool SensorLoop::wait_until_due(int64_t timestamp_us, bool& too_late) {
    too_late = false;
    if (!params_.paced) return true;
    if (!running_) ring_.say(RingState::ready);
    while (ring_.play_at_us() == 0)
        if (!rest(milliseconds(2))) return false;
    for (;;) {
        const int64_t left = ring_.play_at_us() + timestamp_us - host_now_us();
        too_late = -left > too_late_us && !ring_.geometry().blocking;
        if (left <= 0) return true;
        const int64_t pause = std::min<int64_t>(left, std::chrono::microseconds(longest_wait).count());
        // The recording's own clock says when the next frame is due; nothing else could wake us.
        std::this_thread::sleep_for(std::chrono::microseconds(pause));
        ring_.beat();
        if (must_end()) return false;
    }
}

bool SensorLoop::wait_for_slot() {
    if (!ring_.geometry().blocking) return true;
    while (ring_.full())
        if (!rest(milliseconds(1))) return false;
    return true;
}

void SensorLoop::deliver(uint64_t frame_id) {
    if (!running_) ring_.say(RingState::running);
    running_ = true;
    ring_.publish({frame_.timestamp_us, host_now_us(), frame_id}, frame_.millimetres);
    if (params_.bell < 0) return;
    // A full bell has rung already.
    if (write(params_.bell, "", 1) < 0) return;
}

Result<void> SensorLoop::play_recording() {
    const RingGeometry size = ring_.geometry();
    const auto frames = static_cast<uint64_t>(params_.frames);
    if (frames == 0) {
        ring_.say(RingState::finished);
        return {};
    }
    auto reader = OpenniReader::open(params_.uri, true, size.width, size.height, params_.frames);
    if (!reader) return refuse(reader.error().sentence);
    int64_t last_frame_us = host_now_us();
    for (uint64_t id = 1; id <= frames;) {
        if (must_end()) return {};
        const auto read = reader->read(frame_, longest_wait);
        ring_.beat();
        if (read == OpenniReader::Read::failed) return refuse(reader->failure());
        if (read == OpenniReader::Read::nothing) {
            if (host_now_us() - last_frame_us > longest_silence_us)
                return lose(params_.uri + ": OpenNI2 stopped after " + std::to_string(id - 1) + " of " +
                            std::to_string(frames) + " frames");
            continue;
        }
        if (std::find(frame_.millimetres.begin(), frame_.millimetres.end(), 65535) !=
            frame_.millimetres.end())
            return refuse(params_.uri + ": frame " + std::to_string(id) +
                          " holds the value 65535, which is not a depth");
        // The player spins from the last frame on, so it is stopped before anything is waited for.
        if (id == frames) reader->close();
        bool too_late = false;
        if (id > params_.skip) {
            if (!wait_until_due(frame_.timestamp_us, too_late)) return {};
            if (too_late) {
                ring_.count_lost();
            } else {
                if (!wait_for_slot()) return {};
                deliver(id);
            }
        }
        last_frame_us = host_now_us();
        ++id;
    }
    ring_.say(RingState::finished);
    return {};
}

Result<void> SensorLoop::follow_device() {
    const RingGeometry size = ring_.geometry();
    auto reader = OpenniReader::open(params_.uri, false, size.width, size.height, -1);
    if (!reader) return lose(reader.error().sentence);
    ring_.say(RingState::running);
    int64_t last_frame_us = host_now_us();
    for (uint64_t id = 1; !must_end();) {
        const auto read = reader->read(frame_, longest_wait);
        ring_.beat();
        if (read == OpenniReader::Read::failed) return lose(reader->failure());
        if (read == OpenniReader::Read::nothing) {
            if (host_now_us() - last_frame_us > longest_silence_us)
                return lose(params_.uri + ": has sent no frame for 5 s");
            continue;
        }
        last_frame_us = host_now_us();
        if (!wait_for_slot()) break;
        deliver(id++);
    }
    return {};
}

}  // namespace

void follow_parent() {
    parent = getppid();
    struct sigaction action = {};
    action.sa_handler = on_parent_thread_ended;
    sigaction(SIGHUP, &action, nullptr);
    action.sa_handler = on_end;
    sigaction(SIGTERM, &action, nullptr);
    action.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &action, nullptr);
}

bool asked_to_end() {
    return end_requested != 0;
}

Result<void> run_sensor_child(FrameRingWriter& ring, const SensorChildParams& params) {
    SensorLoop loop(ring, params);
    return params.recording ? loop.play_recording() : loop.follow_device();
}

}  // namespace deixis
