// Meshes, voxels, part and cell as the browser takes them.
#include "hmi/server/screen_messages.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

namespace deixis {
namespace {

static_assert(std::endian::native == std::endian::little, "messages are written as they lie in memory");

class ByteWriter {
  public:
    explicit ByteWriter(size_t expected_bytes) { bytes_.reserve(expected_bytes); }

    template <class T>
    void put(const T& value) {
        const size_t at = bytes_.size();
        bytes_.resize(at + sizeof(T));
        std::memcpy(bytes_.data() + at, &value, sizeof(T));
    }
    std::vector<uint8_t> take() { return std::move(bytes_); }

  private:
    std::vector<uint8_t> bytes_;
};

nlohmann::ordered_json list_of(const Eigen::Vector3d& v) {
    return {v.x(), v.y(), v.z()};
}

const char* kind_name(SensorKind kind) {
    switch (kind) {
        case SensorKind::depth:
            return "depth";
        case SensorKind::infrared:
            return "infrared";
        case SensorKind::video:
            return "video";
    }
    return "depth";
}

}  // namespace

std::vector<uint8_t> encode_mesh(const SurfaceMesh& mesh) {
    ByteWriter out(8 + 12 * mesh.vertices.size() + 12 * mesh.triangles.size());
    out.put(static_cast<uint32_t>(mesh.vertices.size()));
    for (const Eigen::Vector3f& v : mesh.vertices)
        for (int axis = 0; axis < 3; ++axis) out.put(v[axis]);
    out.put(static_cast<uint32_t>(mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles)
        for (const uint32_t corner : triangle) out.put(corner);
    return out.take();
}

std::vector<uint8_t> encode_voxels(std::span<const Eigen::Vector3f> centres, float voxel_size,
                                   int64_t timestamp_us) {
    Eigen::Vector3f least = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
    for (const Eigen::Vector3f& c : centres)
        if (c.allFinite()) least = least.cwiseMin(c);
    const auto cell_of = [&](const Eigen::Vector3f& c) {
        return ((c - least) / voxel_size).array().round().eval();
    };
    const auto fits = [&](const Eigen::Vector3f& c) {
        return c.allFinite() && (cell_of(c) <= 65535.F).all();
    };
    uint32_t count = 0;
    for (const Eigen::Vector3f& c : centres) count += fits(c) ? 1 : 0;
    if (count == 0) least.setZero();

    ByteWriter out(32 + 6 * static_cast<size_t>(count));
    for (const char c : {'D', 'X', 'V', '1'}) out.put(c);
    out.put(count);
    out.put(voxel_size);
    for (int axis = 0; axis < 3; ++axis) out.put(least[axis]);
    out.put(timestamp_us);
    for (const Eigen::Vector3f& c : centres) {
        if (!fits(c)) continue;
        const auto cell = cell_of(c);
        for (int axis = 0; axis < 3; ++axis) out.put(static_cast<uint16_t>(cell[axis]));
    }
    return out.take();
}

std::string part_json(const ScreenPart& part, const std::string& mesh_etag) {
    nlohmann::ordered_json zones = nlohmann::ordered_json::array();
    for (const ScreenZone& zone : part.zones)
        zones.push_back(
            {{"name", zone.name}, {"min", list_of(zone.box.min)}, {"max", list_of(zone.box.max)}});
    const nlohmann::ordered_json json = {
        {"type", part.type}, {"serial", part.serial}, {"zones", zones}, {"mesh_etag", mesh_etag}};
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string cell_json(const SensorRig& rig) {
    nlohmann::ordered_json sensors = nlohmann::ordered_json::array();
    for (const CalibratedSensor& sensor : rig.sensors) {
        nlohmann::ordered_json rows = nlohmann::ordered_json::array();
        for (int row = 0; row < 3; ++row)
            rows.push_back(list_of(sensor.camera_from_world.rotation.row(row).transpose()));
        sensors.push_back({{"name", sensor.name},
                           {"kind", kind_name(sensor.kind)},
                           {"width", sensor.camera.width},
                           {"height", sensor.camera.height},
                           {"fx", sensor.camera.fx},
                           {"fy", sensor.camera.fy},
                           {"cx", sensor.camera.cx},
                           {"cy", sensor.camera.cy},
                           {"rotation", rows},
                           {"translation", list_of(sensor.camera_from_world.translation)}});
    }
    nlohmann::ordered_json cell;
    if (rig.cell) cell = {{"min", list_of(rig.cell->min)}, {"max", list_of(rig.cell->max)}};
    const nlohmann::ordered_json json = {{"sensors", sensors}, {"cell", cell}};
    return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace deixis
