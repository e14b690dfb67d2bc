// The live message.
#include "appliance/station/station_state.h"

#include <algorithm>

namespace deixis {
namespace {

constexpr int stale_after_ms = 1000;

nlohmann::ordered_json sensor_json(const SensorHealth& s) {
    return {
        {"name", s.name},
        {"state", name_of(s.state)},
        {"reason", s.reason},
        {"frames", s.frames},
        {"dropped", s.dropped},
        {"corrupt", s.corrupt},
        {"restarts", s.restarts},
        {"age_ms", s.age_us < 0 ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(s.age_us / 1000)},
        {"skew_us", s.skew_us}};
}

}  // namespace

bool sensors_ok(const StationState& state) {
    return std::all_of(state.sensors.begin(), state.sensors.end(),
                       [](const SensorHealth& s) { return s.state == SensorState::running; });
}

nlohmann::ordered_json live_message(const StationState& state, const FrameResult* frame) {
    nlohmann::ordered_json message;
    message["frame"] = frame ? to_json(*frame) : nlohmann::ordered_json(nullptr);
    auto& sensors = message["sensors"] = nlohmann::ordered_json::array();
    for (const SensorHealth& s : state.sensors) sensors.push_back(sensor_json(s));
    message["plc"] = {{"state", name_of(state.plc.phase)}, {"reason", state.plc.reason}};
    message["record"] = {{"state", name_of(state.record.phase)}, {"reason", state.record.reason}};
    message["session"] = state.source;
    message["progress"] = nullptr;
    if (state.expected > 0)
        message["progress"] =
            std::min(1.0, static_cast<double>(state.framesets) / static_cast<double>(state.expected));
    message["finished"] = state.finished;
    message["marks_total"] = state.marks_total;
    message["trouble"] = state.last_trouble;
    message["stale_after_ms"] = stale_after_ms;
    return message;
}

}  // namespace deixis
