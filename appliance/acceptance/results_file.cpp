// results.jsonl: reading and checking.
#include "appliance/acceptance/results_file.h"

#include <array>
#include <fstream>
#include <set>

#include "appliance/acceptance/json_line.h"

namespace deixis {

namespace {

PartState read_state(const JsonObject& part) {
    const std::optional<std::string> state = part.text("state");
    if (!state) part.refuse("part.state is missing");
    if (*state == "absent") return PartState::absent;
    if (*state == "searching") return PartState::searching;
    if (*state == "ambiguous") return PartState::ambiguous;
    if (*state == "tracking") return PartState::tracking;
    if (*state == "lost") return PartState::lost;
    part.refuse("part.state is \"" + *state + "\", expected absent, searching, ambiguous, tracking or lost");
}

ResultPart read_part(const JsonObject& part) {
    ResultPart out;
    out.state = read_state(part);
    const auto rotation = part.rotation("rotation");
    const auto translation = part.vector("translation");
    const bool tracking = out.state == PartState::tracking;
    if (tracking != rotation.has_value()) {
        part.refuse(tracking ? "part.rotation is missing in state tracking"
                             : "part.rotation stands without state tracking");
    }
    if (tracking != translation.has_value()) {
        part.refuse(tracking ? "part.translation is missing in state tracking"
                             : "part.translation stands without state tracking");
    }
    if (tracking) out.world_from_part = RigidTransform{*rotation, *translation};
    out.at_rest = part.boolean("at_rest");
    out.fitness = part.number("fitness");
    return out;
}

ResultPointing read_result_pointing(const JsonObject& pointing) {
    return {pointing.arm("arm"), pointing.vector("origin"), pointing.vector("direction"),
            pointing.vector("hit_part")};
}

ResultMark read_mark(const JsonObject& mark, std::set<int64_t>& ids) {
    ResultMark out;
    const auto id = mark.integer("id");
    if (!id) mark.refuse("a mark has no id");
    if (!ids.insert(*id).second) mark.refuse("mark " + std::to_string(*id) + " was there before");
    const auto position = mark.vector("position_part");
    if (!position) mark.refuse("mark " + std::to_string(*id) + " has no position_part");
    out.id = *id;
    out.position_part = *position;
    out.zone = mark.text("zone").value_or("");
    return out;
}

}  // namespace

Result<Results> read_results(std::istream& in, const std::string& name) {
    Results results;
    std::set<std::string> seen;
    std::set<int64_t> ids;
    const Result<size_t> lines = read_json_lines(in, name, [&](const JsonObject& line) {
        ResultFrame frame;
        const auto stamp = line.integer("timestamp_us");
        if (!stamp) line.refuse("timestamp_us is missing");
        frame.timestamp_us = *stamp;
        if (!results.frames.empty() && *stamp <= results.frames.back().timestamp_us) {
            line.refuse("timestamp_us " + std::to_string(*stamp) + " does not rise");
        }
        line.warn_unknown({"timestamp_us", "part", "joints", "pose_energy", "pointing", "marks", "stage_ms"},
                          seen, results.warnings);
        if (const auto part = line.object("part")) frame.part = read_part(*part);
        if (const auto pointing = line.object("pointing")) frame.pointing = read_result_pointing(*pointing);
        if (const auto marks = line.objects("marks")) {
            for (const JsonObject& mark : *marks) frame.marks.push_back(read_mark(mark, ids));
        }
        if (const auto stages = line.object("stage_ms")) {
            for (const std::string& stage : stages->keys()) {
                if (const auto value = stages->number(stage.c_str())) frame.stage_ms[stage] = *value;
            }
        }
        results.frames.push_back(std::move(frame));
    });
    if (!lines) return tl::unexpected<Failure>(lines.error());
    return results;
}

Result<Results> read_results(const std::filesystem::path& path) {
    std::ifstream in(path);
    if (!in || std::filesystem::is_directory(path)) return fail(path.string() + " cannot be read");
    return read_results(in, path.string());
}

}  // namespace deixis
