// Framesets from sensor children, in lock-step or live. In: what each sensor delivers; out: paired framesets.
#include "appliance/sensors/frame_source.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include "appliance/sensors/frame_pairing.h"
#include "appliance/sensors/host_clock.h"
#include "appliance/sensors/supervised_sensor.h"

namespace deixis {
namespace {

using std::chrono::milliseconds;

constexpr size_t longest_queue = 32;           ///< live: frames of a sensor that wait for a partner
constexpr milliseconds watch_interval{10};     ///< how often the children are looked after
constexpr int64_t start_together_us = 50'000;  ///< paced recordings: from all ready to the first frame
constexpr int64_t longest_wait_for_start_us = 30'000'000;

class SensorFramesets : public FrameSource {
  public:
    SensorFramesets(const std::vector<SensorSpec>& specs, const FrameSourceParams& params)
        : params_(params), pairing_(specs.size(), params.pairing_window_us), created_us_(host_now_us()) {
        for (const SensorSpec& spec : specs) sensors_.emplace_back(spec, params);
        newest_us_.assign(specs.size(), 0);
        periods_us_.assign(specs.size(), 0);
        session_zero_us_ = INT64_MAX;
        for (const SensorSpec& spec : specs)
            if (spec.recording) session_zero_us_ = std::min(session_zero_us_, spec.start_us);
        watch();
    }

    ~SensorFramesets() override { end_in_order(sensors_); }

    Outcome next(Frameset& out, milliseconds patience) override {
        const int64_t deadline = host_now_us() + std::chrono::microseconds(patience).count();
        for (;;) {
            watch();
            const bool found = !params_.lock_step         ? next_live(out)
                               : params_.clock_us.empty() ? next_lock_step(out)
                                                          : next_of_clock(out);
            if (found) {
                note_skews(out);
                return Outcome::frameset;
            }
            if (is_over()) return Outcome::end;
            const int64_t left = deadline - host_now_us();
            if (left <= 0) return Outcome::timeout;
            wait_for_bell(sensors_, std::min(watch_interval, milliseconds(left / 1000 + 1)));
        }
    }

    std::vector<SensorHealth> health() const override {
        const std::lock_guard lock(health_mutex_);
        return health_;
    }

  private:
    void watch();
    bool next_lock_step(Frameset& out);
    bool next_of_clock(Frameset& out);
    bool partners_have_passed(size_t first, int64_t stamp);
    bool clock_is_over() const;
    bool next_live(Frameset& out);
    size_t live_clock() const;
    bool must_wait_for_partners(size_t clock) const;
    bool is_heard(size_t i) const;
    bool is_over() const;
    void drain(size_t first);
    void note_skews(const Frameset& frameset);
    bool take_into_queue(size_t i);

    FrameSourceParams params_;
    std::vector<SupervisedSensor> sensors_;
    FramePairing pairing_;
    SensorFrame spare_;
    int64_t created_us_;
    int64_t session_zero_us_;
    size_t clock_next_ = 0;  ///< of `clock_us`
    bool playing_ = false;
    int64_t last_stamp_us_ = INT64_MIN;
    std::vector<int64_t> newest_us_, periods_us_;  ///< of each sensor: its last stamp, and the gap before it
    mutable std::mutex health_mutex_;
    std::vector<SensorHealth> health_;
};

void SensorFramesets::watch() {
    for (SupervisedSensor& sensor : sensors_) sensor.watch();
    if (!playing_) {
        const bool settled =
            std::all_of(sensors_.begin(), sensors_.end(), [](auto& s) { return s.has_settled(); });
        if (settled || host_now_us() - created_us_ > longest_wait_for_start_us) {
            playing_ = true;
            const int64_t start = host_now_us() + start_together_us;
            for (SupervisedSensor& sensor : sensors_)
                if (sensor.spec().recording)
                    sensor.play_at(start + sensor.spec().start_us - session_zero_us_);
        }
    }
    const std::lock_guard lock(health_mutex_);
    health_.resize(sensors_.size());
    for (size_t i = 0; i < sensors_.size(); ++i) health_[i] = sensors_[i].health();
}

bool SensorFramesets::take_into_queue(size_t i) {
    if (!sensors_[i].take(spare_)) return false;
    const int64_t stamp = spare_.frame.timestamp_us;
    // Twice the window at most: after a lost frame the next comes sooner than the last gap says.
    periods_us_[i] = std::clamp<int64_t>(stamp - newest_us_[i], 0, 2 * params_.pairing_window_us);
    newest_us_[i] = stamp;
    pairing_.put(i, spare_.frame);
    return true;
}

/// Every stream from `first` on has passed the stamp or is over; at most two frames of each are held.
bool SensorFramesets::partners_have_passed(size_t first, int64_t stamp) {
    for (size_t i = first; i < sensors_.size(); ++i) {
        pairing_.forget_before(i, stamp);
        while (!pairing_.has_passed(i, stamp)) {
            if (!take_into_queue(i)) {
                if (sensors_[i].is_over()) break;
                return false;
            }
            pairing_.forget_before(i, stamp);
        }
    }
    return true;
}

/// Waits, by returning false, until every other stream has passed the first sensor's frame or is over; never
/// more than one frame of the first is held.
bool SensorFramesets::next_lock_step(Frameset& out) {
    if (pairing_.waiting(0) == 0 && !take_into_queue(0)) {
        if (sensors_[0].is_over()) drain(1);
        return false;
    }
    if (!partners_have_passed(1, pairing_.front(0).timestamp_us)) return false;
    pairing_.take(0, out);
    return true;
}

/// The same, clocked from outside.
bool SensorFramesets::next_of_clock(Frameset& out) {
    if (clock_next_ == params_.clock_us.size()) {
        drain(0);
        return false;
    }
    const int64_t stamp = params_.clock_us[clock_next_];
    if (!partners_have_passed(0, stamp)) return false;
    pairing_.take_at(stamp, out);
    ++clock_next_;
    return true;
}

/// What the sensors from `first` on recorded after the clock's end belongs to no frameset; it is taken all
/// the same, so that whether their recordings are whole does not depend on who was faster.
void SensorFramesets::drain(size_t first) {
    for (size_t i = first; i < sensors_.size(); ++i) {
        while (pairing_.waiting(i) > 0) pairing_.drop_front(i);
        if (params_.real_time) continue;  // nobody waits for them at their own pace
        while (sensors_[i].take(spare_)) {
        }
    }
}

/// A sensor whose frames are worth waiting for.
bool SensorFramesets::is_heard(size_t i) const {
    const SensorHealth& h = sensors_[i].health();
    return h.state == SensorState::running &&
           h.age_us <= std::chrono::microseconds(params_.silence_limit).count();
}

/// The first sensor that is heard or has frames left; past the end when there is none.
size_t SensorFramesets::live_clock() const {
    for (size_t i = 0; i < sensors_.size(); ++i)
        if (pairing_.waiting(i) > 0 || is_heard(i)) return i;
    return sensors_.size();
}

bool SensorFramesets::must_wait_for_partners(size_t clock) const {
    const DepthFrame& frame = pairing_.front(clock);
    if (host_now_us() - frame.host_us > std::chrono::microseconds(params_.pair_patience).count())
        return false;
    for (size_t i = 0; i < sensors_.size(); ++i)
        if (i != clock && is_heard(i) && pairing_.may_come_nearer(i, frame.timestamp_us, periods_us_[i]))
            return true;
    return false;
}

bool SensorFramesets::next_live(Frameset& out) {
    for (size_t i = 0; i < sensors_.size(); ++i) {
        while (take_into_queue(i))
            if (pairing_.waiting(i) > longest_queue) pairing_.drop_front(i);
    }
    for (;;) {
        const size_t clock = live_clock();
        if (clock == sensors_.size() || pairing_.waiting(clock) == 0) return false;
        if (pairing_.front(clock).timestamp_us <= last_stamp_us_) {
            pairing_.drop_front(clock);  // another sensor clocked a frameset past it while this one was away
        } else if (pairing_.waiting(clock) > static_cast<size_t>(params_.live_backlog)) {
            pairing_.drop_front(clock);
            sensors_[clock].count_dropped();
        } else if (must_wait_for_partners(clock)) {
            return false;
        } else {
            pairing_.take(clock, out);
            last_stamp_us_ = out.timestamp_us;
            return true;
        }
    }
}

bool SensorFramesets::clock_is_over() const {
    if (!params_.clock_us.empty()) return clock_next_ == params_.clock_us.size();
    return pairing_.waiting(0) == 0 && sensors_[0].is_over();
}

bool SensorFramesets::is_over() const {
    if (params_.lock_step) {
        if (!clock_is_over()) return false;
        const bool refused = params_.clock_us.empty() && sensors_[0].health().state == SensorState::missing;
        if (params_.real_time || refused) return true;
    }
    for (size_t i = 0; i < sensors_.size(); ++i)
        if (!sensors_[i].is_over() || pairing_.waiting(i) > 0) return false;
    return true;
}

void SensorFramesets::note_skews(const Frameset& frameset) {
    for (size_t i = 0; i < sensors_.size(); ++i)
        if (frameset.frames[i].present)
            sensors_[i].note_skew(frameset.frames[i].timestamp_us - frameset.timestamp_us);
}

}  // namespace

const char* name_of(SensorState state) {
    switch (state) {
        case SensorState::starting:
            return "starting";
        case SensorState::running:
            return "running";
        case SensorState::stalled:
            return "stalled";
        case SensorState::restarting:
            return "restarting";
        case SensorState::missing:
            return "missing";
        case SensorState::finished:
            return "finished";
    }
    return "";
}

InvalidSettings FrameSourceParams::validate() const {
    InvalidSettings complaints;
    const auto ms = [](milliseconds t) { return static_cast<double>(t.count()); };
    require_range(complaints, "pairing_window_us", static_cast<double>(pairing_window_us), 0, 1e6);
    require_range(complaints, "stall_limit", ms(stall_limit), 100, 60'000);
    require_range(complaints, "pair_patience", ms(pair_patience), 0, 1'000);
    require_range(complaints, "restart_delay", ms(restart_delay), 1, 8'000);
    require_range(complaints, "start_limit", ms(start_limit), 100, 600'000);
    require_range(complaints, "silence_limit", ms(silence_limit), 1, 10'000);
    require_range(complaints, "ring_frames", ring_frames, 2, 256);
    require_range(complaints, "live_backlog", live_backlog, 1, 30);
    if (program.empty()) complaints.push_back({"program", "\"\"", "the path of the deixis program"});
    return complaints;
}

Result<std::unique_ptr<FrameSource>> open_sensors(const std::vector<SensorSpec>& sensors,
                                                  const FrameSourceParams& params) {
    if (sensors.empty()) return fail("no sensor is given, expected at least one");
    for (const InvalidSetting& s : params.validate())
        return fail("sensors." + s.key + " is " + s.value + ", expected " + s.range);
    for (const SensorSpec& s : sensors) {
        if (s.width < 1 || s.width > 8192 || s.height < 1 || s.height > 8192)
            return fail("sensor \"" + s.name + "\" has the size " + std::to_string(s.width) + "x" +
                        std::to_string(s.height) + ", expected sides of 1 to 8192");
        if (params.lock_step && !s.recording)
            return fail("sensor \"" + s.name + "\" is a live device, lock-step needs recordings");
        if (s.recording && s.uri.empty()) return fail("sensor \"" + s.name + "\" names no recording");
    }
    remove_left_over_rings();
    return std::make_unique<SensorFramesets>(sensors, params);
}

}  // namespace deixis
