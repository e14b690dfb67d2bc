// Plays a recording in real time. In: frames of an .oni file and the host's clock; out: calls at the right
// moment.
#include "appliance/simulation/driver/virtual_playback.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "appliance/sessions/oni_walker.h"

namespace deixis {
namespace {

using std::chrono::microseconds;

constexpr int64_t too_late_us = 20'000;

int64_t now_us() {
    return std::chrono::duration_cast<microseconds>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Waits as a device does until its next exposure. False when `stop` came first.
bool sleep_until(int64_t due_us, const std::stop_token& stop) {
    for (;;) {
        if (stop.stop_requested()) return false;
        const int64_t left = due_us - now_us();
        if (left <= 0) return true;
        std::this_thread::sleep_for(microseconds(std::min<int64_t>(left, 20'000)));
    }
}

void play_round(const VirtualSensor& sensor, int64_t round_begin_us, const VirtualPlayback::Send& send,
                const std::stop_token& stop) {
    const auto each = [&](int64_t, int64_t timestamp_us, const DepthImage& image) {
        const int64_t due = round_begin_us + sensor.start_us + timestamp_us;
        if (now_us() - due > too_late_us) return !stop.stop_requested();
        if (!sleep_until(due, stop)) return false;
        send(due, image);
        return true;
    };
    // A recording that has become unreadable ends the round; the stream is then as silent as a broken camera.
    (void)read_oni(sensor.recording, each);
}

}  // namespace

void VirtualPlayback::start(const VirtualSensor& sensor, Send send) {
    stop();
    player_ = std::jthread([sensor, send = std::move(send)](const std::stop_token& stop) {
        do {
            const int64_t round_begin = now_us() / sensor.period_us * sensor.period_us;
            play_round(sensor, round_begin, send, stop);
            sleep_until(round_begin + sensor.period_us, stop);
        } while (!stop.stop_requested());
    });
}

void VirtualPlayback::stop() {
    player_.request_stop();
    if (player_.joinable()) player_.join();
}

}  // namespace deixis
