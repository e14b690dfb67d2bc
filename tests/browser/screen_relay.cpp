// Puts a scripted station behind the real screen server: commands on stdin, one JSON object a line, become
// what the feed answers and what the live stream says. Prints the address first; ends with its input.
//   {"part": {"type", "serial", "zones", "vertices": [x, y, z...], "triangles": [a, b, c...]} | null}
//   {"rig": {"sensors": [...], "cell": {"min", "max"}}}   as in /api/cell
//   {"marks": [...]}
//   {"live": {...}, "voxels": [x, y, z...], "voxel_size": 0.03, "timestamp_us": 0}
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>

#include "hmi/server/screen_messages.h"
#include "hmi/server/screen_server.h"

namespace {

using deixis::ScreenPart;
using deixis::SensorRig;
using nlohmann::json;

Eigen::Vector3d vector_of(const json& list) {
    return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

class ScriptedFeed : public deixis::ScreenFeed {
  public:
    std::shared_ptr<const ScreenPart> part() override { return locked(part_); }
    std::shared_ptr<const SensorRig> rig() override { return locked(rig_); }
    deixis::Result<std::string> marks_json() override { return locked(marks_); }

    void set_part(const json& given) {
        auto part = std::make_shared<ScreenPart>();
        part->type = given.at("type");
        part->serial = given.at("serial");
        for (const json& zone : given.at("zones"))
            part->zones.push_back({zone.at("name"), {vector_of(zone.at("min")), vector_of(zone.at("max"))}});
        const auto vertices = given.at("vertices").get<std::vector<float>>();
        for (size_t i = 0; i + 2 < vertices.size(); i += 3)
            part->mesh.vertices.emplace_back(vertices[i], vertices[i + 1], vertices[i + 2]);
        const auto corners = given.at("triangles").get<std::vector<uint32_t>>();
        for (size_t i = 0; i + 2 < corners.size(); i += 3)
            part->mesh.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
        replace(part_, std::shared_ptr<const ScreenPart>(std::move(part)));
    }

    void set_rig(const json& given) {
        auto rig = std::make_shared<SensorRig>();
        for (const json& entry : given.at("sensors")) {
            deixis::CalibratedSensor sensor;
            sensor.name = entry.at("name");
            sensor.camera.width = entry.at("width");
            sensor.camera.height = entry.at("height");
            sensor.camera.fx = entry.at("fx");
            sensor.camera.fy = entry.at("fy");
            sensor.camera.cx = entry.at("cx");
            sensor.camera.cy = entry.at("cy");
            for (int row = 0; row < 3; ++row)
                sensor.camera_from_world.rotation.row(row) =
                    vector_of(entry.at("rotation").at(row)).transpose();
            sensor.camera_from_world.translation = vector_of(entry.at("translation"));
            rig->sensors.push_back(sensor);
        }
        const json& cell = given.at("cell");
        rig->cell = deixis::Box{vector_of(cell.at("min")), vector_of(cell.at("max"))};
        replace(rig_, std::shared_ptr<const SensorRig>(std::move(rig)));
    }

    void set_marks(const json& given) { replace(marks_, given.dump()); }

  private:
    template <class T>
    T locked(const T& member) {
        const std::lock_guard lock(mutex_);
        return member;
    }
    template <class T>
    void replace(T& member, T value) {
        const std::lock_guard lock(mutex_);
        member = std::move(value);
    }

    std::mutex mutex_;
    std::shared_ptr<const ScreenPart> part_;
    std::shared_ptr<const SensorRig> rig_;
    std::string marks_ = "[]";
};

std::vector<uint8_t> voxels_of(const json& command) {
    if (!command.contains("voxels")) return {};
    const auto numbers = command.at("voxels").get<std::vector<float>>();
    std::vector<Eigen::Vector3f> centres;
    for (size_t i = 0; i + 2 < numbers.size(); i += 3)
        centres.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    return deixis::encode_voxels(centres, command.at("voxel_size"), command.at("timestamp_us"));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::cerr << "screen_relay WEB_ROOT [PORT]: name the folder of the built page.\n";
        return 2;
    }
    deixis::ScreenServerParams params;
    params.web_root = argv[1];
    params.port = argc > 2 ? std::atoi(argv[2]) : 0;
    ScriptedFeed feed;
    auto server = deixis::ScreenServer::start(params, feed);
    if (!server) {
        std::cerr << server.error().sentence << "\n";
        return 1;
    }
    std::cout << (*server)->address() << std::endl;
    for (std::string line; std::getline(std::cin, line);) {
        try {
            const json command = json::parse(line);
            if (command.contains("part")) feed.set_part(command.at("part"));
            if (command.contains("rig")) feed.set_rig(command.at("rig"));
            if (command.contains("marks")) feed.set_marks(command.at("marks"));
            if (command.contains("live")) (*server)->publish(command.at("live").dump(), voxels_of(command));
        } catch (const json::exception& error) {
            std::cerr << "command refused: " << error.what() << "\n";
            return 1;
        }
    }
    return 0;
}
