// Reads the plan of the virtual sensors. In: a TOML file or a session folder; out: sensors.
#include "appliance/simulation/driver/virtual_plan.h"

#include <toml++/toml.h>
#include <algorithm>
#include <map>
#include <optional>

#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/session.h"

namespace deixis {
namespace {

constexpr int64_t frame_gap_us = 33'333;

std::optional<VirtualBehaviour> behaviour_of(const std::string& word) {
    static const std::map<std::string, VirtualBehaviour> words = {
        {"running", VirtualBehaviour::running}, {"unplugged", VirtualBehaviour::unplugged},
        {"silent", VirtualBehaviour::silent},   {"small", VirtualBehaviour::small},
        {"garbage", VirtualBehaviour::garbage}, {"backwards", VirtualBehaviour::backwards},
        {"stuck", VirtualBehaviour::stuck}};
    const auto found = words.find(word);
    if (found == words.end()) return std::nullopt;
    return found->second;
}

Result<VirtualSensor> sensor_of(const std::string& name, const toml::table& table,
                                const std::filesystem::path& file) {
    VirtualSensor sensor;
    sensor.name = name;
    const auto where = [&](const std::string& key) { return file.string() + ": " + name + "." + key; };
    for (const auto& [key, value] : table) {
        const std::string word(key.str());
        if (word == "recording" && value.is_string()) {
            sensor.recording = file.parent_path() / *value.value<std::string>();
        } else if (word == "state" && value.is_string()) {
            const auto behaviour = behaviour_of(*value.value<std::string>());
            if (!behaviour)
                return fail(where(word) +
                            ": expected running, unplugged, silent, small, garbage, backwards or stuck");
            sensor.behaviour = *behaviour;
        } else if (word == "start_us" && value.is_integer()) {
            sensor.start_us = *value.value<int64_t>();
        } else if (word == "period_us" && value.is_integer()) {
            sensor.period_us = *value.value<int64_t>();
        } else if (word == "clock_offset_us" && value.is_integer()) {
            sensor.clock_offset_us = *value.value<int64_t>();
        } else {
            return fail(where(word) + ": expected recording, state, start_us, period_us or clock_offset_us");
        }
    }
    if (sensor.recording.empty()) return fail(where("recording") + ": is missing, expected an .oni file");
    if (sensor.period_us < 0) return fail(where("period_us") + ": expected 0 or more");
    return sensor;
}

Result<std::vector<VirtualSensor>> read_control_file(const std::filesystem::path& file) {
    std::vector<VirtualSensor> sensors;
    try {
        const toml::table root = toml::parse_file(file.string());
        for (const auto& [key, value] : root) {
            if (!value.is_table())
                return fail(file.string() + ": " + std::string(key.str()) + ": expected a table");
            auto sensor = sensor_of(std::string(key.str()), *value.as_table(), file);
            if (!sensor) return tl::unexpected(sensor.error());
            sensors.push_back(std::move(*sensor));
        }
    } catch (const toml::parse_error& e) {
        return fail(file.string() + ": line " + std::to_string(e.source().begin.line) + ": " +
                    std::string(e.description()));
    }
    return sensors;
}

Result<std::vector<VirtualSensor>> read_session_folder(const std::filesystem::path& folder) {
    const auto session = open_session(folder, false);
    if (!session) return tl::unexpected(session.error());
    std::vector<VirtualSensor> sensors;
    for (size_t i = 0; i < session->streams.size(); ++i) {
        if (session->rig.sensors[i].kind != SensorKind::depth) continue;
        VirtualSensor sensor;
        sensor.name = session->streams[i].sensor;
        sensor.recording = session->streams[i].file;
        sensor.start_us = session->streams[i].start_us;
        sensors.push_back(std::move(sensor));
    }
    return sensors;
}

}  // namespace

Result<std::vector<VirtualSensor>> read_virtual_plan(const std::filesystem::path& source) {
    auto sensors =
        std::filesystem::is_directory(source) ? read_session_folder(source) : read_control_file(source);
    if (!sensors) return sensors;
    int64_t longest_us = 0;
    for (const VirtualSensor& sensor : *sensors) {
        const auto summary = walk_oni(sensor.recording, OniPixels::skipped);
        if (!summary) return tl::unexpected(summary.error());
        longest_us = std::max(longest_us, sensor.start_us + summary->last_us);
    }
    for (VirtualSensor& sensor : *sensors)
        if (sensor.period_us == 0) sensor.period_us = longest_us + frame_gap_us;
    return sensors;
}

}  // namespace deixis
