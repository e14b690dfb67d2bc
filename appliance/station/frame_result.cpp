// FrameResult as the JSON object of formats.md.
#include "appliance/station/frame_result.h"

#include <cmath>

namespace deixis {
namespace {

using Json = nlohmann::ordered_json;

// Six decimals are a micrometre: enough for any reader, and short lines.
double rounded(double value) {
    return std::round(value * 1e6) / 1e6 + 0.0;
}

Json vector_json(const Eigen::Vector3d& v) {
    return {rounded(v.x()), rounded(v.y()), rounded(v.z())};
}

Json rotation_json(const Eigen::Matrix3d& r) {
    Json rows = Json::array();
    // Nine decimals keep the rows orthonormal far below the 1e-4 that readers ask for.
    for (int i = 0; i < 3; ++i) {
        Json row = Json::array();
        for (int k = 0; k < 3; ++k) row.push_back(std::round(r(i, k) * 1e9) / 1e9 + 0.0);
        rows.push_back(row);
    }
    return rows;
}

Json part_json(const PartEstimate& part) {
    Json json{{"state", name_of(part.state)}};
    const bool known = part.state == PartState::tracking;
    if (known) {
        json["rotation"] = rotation_json(part.world_from_part.rotation);
        json["translation"] = vector_json(part.world_from_part.translation);
    }
    json["at_rest"] = known ? Json(part.at_rest) : Json(nullptr);
    json["fitness"] = known ? Json(rounded(part.fitness)) : Json(nullptr);
    if (!known && !part.reason.empty()) json["reason"] = part.reason;
    return json;
}

Json pointing_json(const std::optional<PointingRay>& ray) {
    if (!ray) return nullptr;
    return {{"arm", name_of(ray->arm)},
            {"origin", vector_json(ray->origin)},
            {"direction", vector_json(ray->direction)},
            {"hit_part", ray->hit ? vector_json(ray->hit->position) : Json(nullptr)}};
}

Json marks_json(const std::vector<CommittedMark>& marks) {
    Json list = Json::array();
    for (const CommittedMark& m : marks)
        list.push_back({{"id", m.id},
                        {"position_part", vector_json(m.mark.spot.position)},
                        {"normal_part", vector_json(m.mark.spot.normal)},
                        {"zone", m.zone.empty() ? Json(nullptr) : Json(m.zone)},
                        {"arm", name_of(m.mark.arm)},
                        {"confidence", rounded(m.mark.confidence)},
                        {"touch", m.mark.touch}});
    return list;
}

double milliseconds(double value) {
    return std::round(value * 1e3) / 1e3;
}

}  // namespace

nlohmann::ordered_json to_json(const FrameResult& result) {
    const StageTimes& t = result.stage_ms;
    return {{"timestamp_us", result.timestamp_us},
            {"part", part_json(result.part)},
            {"joints", nullptr},
            {"pose_energy", nullptr},
            {"pointing", pointing_json(result.pointing)},
            {"marks", marks_json(result.marks)},
            {"stage_ms",
             {{"foreground", milliseconds(t.foreground)},
              {"part", milliseconds(t.part)},
              {"carve", milliseconds(t.carve)},
              {"worker", milliseconds(t.worker)},
              {"gesture", milliseconds(t.gesture)},
              {"record", milliseconds(t.record)},
              {"total", milliseconds(t.total)}}}};
}

}  // namespace deixis
