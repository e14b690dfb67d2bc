// The binary messages: what goes in comes out, and nonsense is left out.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "hmi/server/screen_messages.h"
#include "tests/hmi/server/made_up_screen.h"

namespace deixis {
namespace {

template <class T>
T read_at(const std::vector<uint8_t>& bytes, size_t offset) {
    T value;
    EXPECT_LE(offset + sizeof(T), bytes.size());
    std::memcpy(&value, bytes.data() + offset, sizeof(T));
    return value;
}

/// The plain reading of a voxel message, as the browser does it.
std::vector<Eigen::Vector3f> decoded(const std::vector<uint8_t>& bytes) {
    const auto size = read_at<float>(bytes, 8);
    std::vector<Eigen::Vector3f> centres;
    for (uint32_t i = 0; i < read_at<uint32_t>(bytes, 4); ++i) {
        Eigen::Vector3f centre;
        for (int axis = 0; axis < 3; ++axis)
            centre[axis] =
                read_at<float>(bytes, 12 + 4 * axis) + size * read_at<uint16_t>(bytes, 32 + 6 * i + 2 * axis);
        centres.push_back(centre);
    }
    return centres;
}

TEST(VoxelMessage, VoxelsOfOneGridComeBackInOrder) {
    std::mt19937 random(3);
    std::vector<Eigen::Vector3f> centres;
    for (int i = 0; i < 5000; ++i) {
        const auto cell = [&] { return static_cast<float>(random() % 200) - 100; };
        centres.emplace_back(0.015F + 0.03F * cell(), 0.015F + 0.03F * cell(), 0.015F + 0.03F * cell());
    }
    const auto bytes = encode_voxels(centres, 0.03F, 123456789012345);
    EXPECT_EQ(std::memcmp(bytes.data(), "DXV1", 4), 0);
    EXPECT_EQ(bytes.size(), 32 + 6 * centres.size());
    EXPECT_EQ(read_at<int64_t>(bytes, 24), 123456789012345);
    const auto back = decoded(bytes);
    ASSERT_EQ(back.size(), centres.size());
    for (size_t i = 0; i < back.size(); ++i) EXPECT_LT((back[i] - centres[i]).norm(), 1e-4) << i;
}

TEST(VoxelMessage, NoVoxelsAreAMessageToo) {
    const auto bytes = encode_voxels({}, 0.03F, 5);
    EXPECT_EQ(bytes.size(), 32U);
    EXPECT_TRUE(decoded(bytes).empty());
}

TEST(VoxelMessage, NonsenseIsLeftOut) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinite = std::numeric_limits<float>::infinity();
    const std::vector<Eigen::Vector3f> centres = {{0, 0, 0},         {nan, 0, 0}, {0, infinite, 0},
                                                  {0, 0, -infinite}, {1, 2, 3},   {0, 0, 1e9F}};
    const auto back = decoded(encode_voxels(centres, 0.5F, 0));
    ASSERT_EQ(back.size(), 2U);
    EXPECT_EQ(back[1], Eigen::Vector3f(1, 2, 3));
    EXPECT_TRUE(decoded(encode_voxels(std::vector<Eigen::Vector3f>{{nan, nan, nan}}, 0.5F, 0)).empty());
}

TEST(MeshMessage, HoldsEveryCornerInOrder) {
    const SurfaceMesh mesh = made_up_part()->mesh;
    const auto bytes = encode_mesh(mesh);
    ASSERT_EQ(bytes.size(), 8 + 12 * mesh.vertices.size() + 12 * mesh.triangles.size());
    EXPECT_EQ(read_at<uint32_t>(bytes, 0), mesh.vertices.size());
    for (size_t v = 0; v < mesh.vertices.size(); ++v)
        for (size_t axis = 0; axis < 3; ++axis)
            EXPECT_EQ(read_at<float>(bytes, 4 + 12 * v + 4 * axis), mesh.vertices[v][static_cast<int>(axis)]);
    const size_t after = 4 + 12 * mesh.vertices.size();
    EXPECT_EQ(read_at<uint32_t>(bytes, after), mesh.triangles.size());
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (size_t corner = 0; corner < 3; ++corner)
            EXPECT_EQ(read_at<uint32_t>(bytes, after + 4 + 12 * t + 4 * corner), mesh.triangles[t][corner]);
    EXPECT_EQ(encode_mesh({}).size(), 8U);
}

TEST(CellJson, SensorsStandWithLensAndPlace) {
    SensorRig rig;
    CalibratedSensor sensor;
    sensor.name = "left";
    sensor.camera.width = 640;
    sensor.camera.fx = 575.8;
    sensor.camera_from_world.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix();
    sensor.camera_from_world.translation = {1, 2, 3};
    rig.sensors = {sensor};
    const auto json = nlohmann::json::parse(cell_json(rig));
    EXPECT_TRUE(json.at("cell").is_null());
    const auto& told = json.at("sensors").at(0);
    EXPECT_EQ(told.at("name"), "left");
    EXPECT_EQ(told.at("kind"), "depth");
    EXPECT_EQ(told.at("fx"), 575.8);
    EXPECT_EQ(told.at("translation"), nlohmann::json({1.0, 2.0, 3.0}));
    EXPECT_DOUBLE_EQ(told.at("rotation").at(1).at(2), -std::sin(0.3));
    rig.cell = Box{{-2, -1.5, 0}, {2, 1.5, 2.2}};
    EXPECT_EQ(nlohmann::json::parse(cell_json(rig)).at("cell").at("max"), nlohmann::json({2.0, 1.5, 2.2}));
}

TEST(PartJson, NamesWithAnyBytesAreStillJson) {
    ScreenPart part = *made_up_part();
    part.serial = "a\"b\\c\n\xFF";
    const auto json = nlohmann::json::parse(part_json(part, "\"tag\""));
    EXPECT_EQ(json.at("type"), "bumper-front-a");
    EXPECT_EQ(json.at("serial"), "a\"b\\c\n\xEF\xBF\xBD");
    EXPECT_EQ(json.at("zones").at(0).at("min"), nlohmann::json({-1.0, -1.0, 0.0}));
    EXPECT_EQ(json.at("mesh_etag"), "\"tag\"");
}

}  // namespace
}  // namespace deixis
