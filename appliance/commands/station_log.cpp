// The station's lines on standard output.
#include "appliance/commands/station_log.h"

#include <algorithm>
#include <cstdio>

namespace deixis {
namespace {

/// A shift of framesets would fill memory; a day at 30 a second is 2.6 million floats, and that is enough.
constexpr size_t most_totals = 3'000'000;

}  // namespace

void StationLog::change(const std::string& what, const std::string& now) {
    std::string& before = told_[what];
    if (before == now) return;
    before = now;
    std::printf("%s %s\n", what.c_str(), now.c_str());
    std::fflush(stdout);
}

void StationLog::tell_changes(const StationState& state) {
    const auto with_reason = [](const char* name, const std::string& reason) {
        return reason.empty() ? std::string(name) : std::string(name) + ": " + reason;
    };
    for (const SensorHealth& sensor : state.sensors)
        change("SENSOR " + sensor.name, with_reason(name_of(sensor.state), sensor.reason));
    const bool record_well =
        state.record.phase == RecorderPhase::ready || state.record.phase == RecorderPhase::writing;
    change("RECORD", record_well ? "ready" : with_reason(name_of(state.record.phase), state.record.reason));
    if (state.plc.phase != LinkPhase::off)
        change("PLC", with_reason(name_of(state.plc.phase), state.plc.reason));
    if (!state.plc_said.empty()) change("PLC-NOTE", state.plc_said);
    if (!state.last_trouble.empty()) change("TROUBLE", state.last_trouble);
}

void StationLog::tell(const Station& station, bool fresh) {
    for (const DefectRecord& record : station.acknowledged()) {
        const Eigen::Vector3d mm = 1000 * record.mark.spot.position;
        std::printf("MARK %lld part_mm %.1f %.1f %.1f zone \"%s\" arm %s at_us %lld\n",
                    static_cast<long long>(record.id), mm.x(), mm.y(), mm.z(), record.zone.c_str(),
                    name_of(record.mark.arm), static_cast<long long>(record.mark.timestamp_us));
    }
    if (!station.acknowledged().empty()) std::fflush(stdout);
    const StationState state = station.state();
    tell_changes(state);
    if (!fresh) return;
    const FrameResult& result = station.result();
    change("PART", result.part.state == PartState::tracking
                       ? (result.part.at_rest ? "tracking, at rest" : "tracking, moving")
                   : result.part.reason.empty()
                       ? name_of(result.part.state)
                       : std::string(name_of(result.part.state)) + ": " + result.part.reason);
    if (totals_ms_.size() < most_totals) totals_ms_.push_back(static_cast<float>(result.stage_ms.total));
    if (!progress_ || state.expected <= 0) return;
    const int percent = static_cast<int>(100 * state.framesets / state.expected);
    if (percent / 5 == last_percent_ / 5 && last_percent_ >= 0) return;
    last_percent_ = percent;
    std::printf("PROGRESS %d %% (%lld of %lld framesets)\n", percent, static_cast<long long>(state.framesets),
                static_cast<long long>(state.expected));
    std::fflush(stdout);
}

void StationLog::summary(const Station& station) const {
    const StationState state = station.state();
    uint64_t taken = 0, dropped = 0;
    for (const SensorHealth& sensor : state.sensors) {
        taken += sensor.frames;
        dropped += sensor.dropped;
    }
    const uint64_t frames = taken + dropped;
    std::vector<float> sorted = totals_ms_;
    std::sort(sorted.begin(), sorted.end());
    const auto percentile = [&](double share) {
        return sorted.empty() ? 0.0F
                              : sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
    };
    std::printf(
        "framesets %lld, marks %lld, stage_ms.total median %.1f ms, 99th percentile %.1f ms, "
        "frames dropped %.2f %% (%llu of %llu)\n",
        static_cast<long long>(state.framesets), static_cast<long long>(state.marks_total), percentile(0.5),
        percentile(0.99), frames ? 100.0 * static_cast<double>(dropped) / static_cast<double>(frames) : 0.0,
        static_cast<unsigned long long>(dropped), static_cast<unsigned long long>(frames));
    std::fflush(stdout);
}

}  // namespace deixis
