// The life of one sensor child as the station sees it. In: ring and process; out: frames and a state.
#include "appliance/sensors/supervised_sensor.h"

#include <poll.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "appliance/sensors/host_clock.h"

namespace deixis {
namespace {

constexpr int64_t longest_delay_us = 8'000'000;
constexpr int tries_without_frame = 5;
constexpr int refused_frames_in_a_row = 3;

int64_t in_us(std::chrono::milliseconds t) {
    return std::chrono::microseconds(t).count();
}

std::string seconds(int64_t us) {
    const std::string tenths = std::to_string(us / 100'000);
    return (tenths.size() > 1 ? tenths.substr(0, tenths.size() - 1) : "0") + "." + tenths.back() + " s";
}

}  // namespace

SupervisedSensor::SupervisedSensor(SensorSpec spec, const FrameSourceParams& params)
    : spec_(std::move(spec)), params_(params) {
    health_.name = spec_.name;
    reason_ = "its first frame has not come yet";
    publish_health();
}
SupervisedSensor::~SupervisedSensor() = default;
SupervisedSensor::SupervisedSensor(SupervisedSensor&&) noexcept = default;

void SupervisedSensor::watch() {
    if (!is_over()) {
        if (!child_ && !ring_ && host_now_us() >= start_after_us_) start();
        if (ring_) watch_child();
    }
    publish_health();
}

void SupervisedSensor::start() {
    auto ring = FrameRingReader::create(unique_ring_name(),
                                        {spec_.width, spec_.height, params_.ring_frames, params_.lock_step});
    if (!ring) return end_child(SensorState::missing, ring.error().sentence);
    ring_ = std::move(*ring);
    if (play_at_us_ != 0) ring_->play_at(play_at_us_);

    ChildCommand command;
    command.program = params_.program;
    command.arguments = {"sensor",  "--ring", ring_->name(), spec_.recording ? "--recording" : "--uri",
                         spec_.uri, "--bell", "3",           "--quiet"};
    if (spec_.recording)
        command.arguments.insert(command.arguments.end(), {"--skip", std::to_string(delivered_)});
    if (spec_.recording && (params_.real_time || !params_.lock_step))
        command.arguments.emplace_back("--paced");
    if (!params_.driver_folder.empty()) {
        std::string folders = std::filesystem::absolute(params_.driver_folder);
        if (const char* before = std::getenv("LD_LIBRARY_PATH")) folders += std::string(":") + before;
        command.environment.emplace_back("LD_LIBRARY_PATH", folders);
    }
    auto child = ChildProcess::start(command);
    if (!child) return end_child(SensorState::missing, child.error().sentence);
    child_ = std::move(*child);
    clock_ = {};
    if (health_.restarts == 0) state_ = SensorState::starting;
}

/// What the child says and whether it lives. An end is judged only when its last frames have been taken, so
/// that the frames delivered do not depend on who was faster.
void SupervisedSensor::watch_child() {
    const auto end = child_->ended();  // before the status: what the child wrote last is then there
    const auto status = ring_->status();
    if (!status) {
        ++health_.corrupt;
        return end_child(SensorState::restarting,
                         "the sensor process talks nonsense: " + status.error().sentence);
    }
    if (status->state != RingState::created) ring_->unlink();
    if (status->state >= RingState::ready) settled_ = true;
    if (ring_->has_unread()) return;
    if (end) return judge_end(*end);
    if (status->state >= RingState::finished) return;  // it is about to end

    const bool opening = status->state <= RingState::starting;
    const int64_t limit = in_us(opening ? params_.start_limit : params_.stall_limit);
    const int64_t silence = host_now_us() - status->heartbeat_us;
    if (silence > limit) {
        return end_child(SensorState::restarting,
                         "the sensor process gave no sign of life for " + seconds(silence));
    }
    const bool waits = status->state == RingState::ready || (spec_.recording && params_.lock_step);
    if (status->state == RingState::running && !waits && last_arrival_us_ >= 0 &&
        host_now_us() - last_arrival_us_ > in_us(params_.stall_limit)) {
        state_ = SensorState::stalled;
        reason_ = "no frame for " + seconds(host_now_us() - last_arrival_us_);
    }
}

void SupervisedSensor::judge_end(const std::string& end) {
    const auto status = ring_->status();
    const RingState last = status ? status->state : RingState::created;
    const std::string message = status ? status->message : std::string();
    if (last == RingState::finished) {
        finished_ = true;
        const bool whole =
            spec_.frames < 0 || !params_.lock_step || delivered_ == static_cast<uint64_t>(spec_.frames);
        end_child(whole ? SensorState::finished : SensorState::missing,
                  whole ? "the recording has been delivered"
                        : spec_.uri + ": ended after " + std::to_string(delivered_) + " frames, expected " +
                              std::to_string(spec_.frames));
    } else if (last == RingState::refused) {
        given_up_ = true;
        end_child(SensorState::missing, message);
    } else if (last == RingState::lost) {
        end_child(SensorState::missing, message);
    } else {
        end_child(SensorState::restarting, "the sensor process " + end);
    }
}

void SupervisedSensor::end_child(SensorState state, std::string reason) {
    child_.reset();
    if (ring_) dropped_before_ += ring_->dropped();
    ring_.reset();
    settled_ = true;
    refused_in_a_row_ = 0;
    state_ = state;
    reason_ = std::move(reason);
    if (is_over()) return;
    ++failures_;
    if (spec_.recording && failures_ >= tries_without_frame) {
        given_up_ = true;
        state_ = SensorState::missing;
        reason_ += "; given up after " + std::to_string(failures_) + " tries without a frame";
        return;
    }
    const int64_t delay = in_us(params_.restart_delay) << std::min(failures_ - 1, 20);
    start_after_us_ = host_now_us() + std::min(delay, longest_delay_us);
    ++health_.restarts;
}

bool SupervisedSensor::take(SensorFrame& out) {
    if (!ring_ || is_over()) return false;
    for (;;) {
        switch (ring_->take(out.frame, params_.live_backlog + 1)) {
            case FrameRingReader::Take::frame:
                if (params_.lock_step && ring_->frame_id() != delivered_ + 1) {
                    ++health_.corrupt;
                    end_child(SensorState::restarting, "the sensor process sent frame " +
                                                           std::to_string(ring_->frame_id()) + ", expected " +
                                                           std::to_string(delivered_ + 1));
                    return false;
                }
                accept(out);
                return true;
            case FrameRingReader::Take::nothing:
                return false;
            case FrameRingReader::Take::refused_frame:
                ++health_.corrupt;
                if (!params_.lock_step && ++refused_in_a_row_ < refused_frames_in_a_row) {
                    reason_ = ring_->refusal();
                    continue;
                }
                [[fallthrough]];
            case FrameRingReader::Take::refused_ring:
                end_child(SensorState::restarting, "the sensor process talks nonsense: " + ring_->refusal());
                return false;
        }
    }
}

void SupervisedSensor::accept(SensorFrame& out) {
    const int64_t now = host_now_us();
    out.sensor_time_us = out.frame.timestamp_us;
    if (spec_.recording) {
        out.frame.timestamp_us += spec_.start_us;
    } else {
        health_.clock_offset_us = clock_.update(out.sensor_time_us, out.frame.host_us);
        out.frame.timestamp_us += health_.clock_offset_us;
    }
    if (!params_.lock_step) {
        out.frame.timestamp_us = std::max(out.frame.timestamp_us, last_stamp_us_ + 1);
        last_stamp_us_ = out.frame.timestamp_us;
    }
    delivered_ = ring_->frame_id();
    last_arrival_us_ = now;
    ++health_.frames;
    failures_ = 0;
    refused_in_a_row_ = 0;
    state_ = SensorState::running;
    reason_.clear();
}

bool SupervisedSensor::has_settled() const {
    return settled_;
}

void SupervisedSensor::play_at(int64_t host_us) {
    play_at_us_ = host_us;
    if (ring_) ring_->play_at(host_us);
}

void SupervisedSensor::ask_to_end() {
    if (child_) child_->ask_to_end();
}

int SupervisedSensor::bell() const {
    return child_ && !child_->has_ended() ? child_->bell() : -1;
}

void SupervisedSensor::hush() {
    if (child_) child_->hush();
}

void SupervisedSensor::publish_health() {
    health_.state = state_;
    health_.reason = state_ == SensorState::running ? std::string() : reason_;
    health_.dropped = dropped_before_ + dropped_by_station_ + (ring_ ? ring_->dropped() : 0);
    health_.age_us = last_arrival_us_ < 0 ? -1 : host_now_us() - last_arrival_us_;
    health_.process_id = child_ ? child_->process_id() : 0;
}

void wait_for_bell(std::vector<SupervisedSensor>& sensors, std::chrono::milliseconds patience) {
    std::vector<pollfd> bells;
    for (const SupervisedSensor& sensor : sensors)
        if (sensor.bell() >= 0) bells.push_back({sensor.bell(), POLLIN, 0});
    poll(bells.data(), bells.size(), static_cast<int>(patience.count()));
    for (SupervisedSensor& sensor : sensors) sensor.hush();
}

void end_in_order(std::vector<SupervisedSensor>& sensors) {
    for (SupervisedSensor& sensor : sensors) sensor.ask_to_end();
    const int64_t patience_over = host_now_us() + 1'000'000;
    const auto any_alive = [&] {
        return std::any_of(sensors.begin(), sensors.end(), [](SupervisedSensor& s) { return s.is_alive(); });
    };
    while (host_now_us() < patience_over && any_alive()) wait_for_bell(sensors, std::chrono::milliseconds(5));
}

}  // namespace deixis
