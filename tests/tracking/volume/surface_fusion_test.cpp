// Surface points lie on the scene, normals look at the sensor, cell and floor bound them.
#include "tracking/volume/surface_fusion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/tracking/volume/depth_scenes.h"

namespace deixis {
namespace {

struct Fused {
    std::vector<CalibratedSensor> sensors = two_sensors();
    DepthScene scene;
    SurfacePoints points;
};

Fused fuse(const DepthScene& scene, std::optional<Box> cell, SurfaceFusion::Params params = {},
           const SceneNoise& noise = {}, const std::array<double, 5>& lens = {0, 0, 0, 0, 0}) {
    Fused fused;
    fused.scene = scene;
    for (CalibratedSensor& sensor : fused.sensors) sensor.camera.distortion = lens;
    std::vector<std::optional<DepthImage>> background;
    for (const auto& sensor : fused.sensors) background.emplace_back(render(sensor, {}));
    ForegroundModel foreground(fused.sensors, background, {});
    const Frameset frameset = render_all(fused.sensors, scene, 0, noise);
    foreground.update(frameset);
    SurfaceFusion fusion(fused.sensors, cell, params);
    fused.points = fusion.update(frameset, foreground);
    return fused;
}

double distance_to(const Capsule& c, const Eigen::Vector3d& p) {
    const Eigen::Vector3d ab = c.b - c.a;
    return (p - c.a - std::clamp((p - c.a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) * ab).norm() - c.radius;
}

TEST(SurfaceFusion, PointsLieOnTheSceneThroughAnyLens) {
    DepthScene scene;
    scene.capsules = standing_person(0, 0);
    for (const auto& lens :
         {std::array<double, 5>{0, 0, 0, 0, 0}, std::array<double, 5>{-0.2, 0.05, 0.002, -0.002, 0}}) {
        const Fused fused = fuse(scene, std::nullopt, {}, {}, lens);
        ASSERT_GT(fused.points.size(), 5000U);
        for (size_t i = 0; i < fused.points.size(); ++i) {
            const Eigen::Vector3d p = fused.points.positions[i].cast<double>();
            double nearest = std::abs(p.z());
            for (const Capsule& c : scene.capsules) nearest = std::min(nearest, std::abs(distance_to(c, p)));
            ASSERT_LT(nearest, 0.004);
        }
    }
}

TEST(SurfaceFusion, NormalsAreUnitAndLookAtTheirSensor) {
    DepthScene scene;
    scene.boxes = {{{-0.5, 0.3, 0.4}, {0.5, 0.6, 1.0}}};
    const Fused fused = fuse(scene, std::nullopt);
    size_t top = 0;
    double good = 0;
    for (size_t i = 0; i < fused.points.size(); ++i) {
        const Eigen::Vector3f& n = fused.points.normals[i];
        if (n.isZero()) continue;
        ASSERT_NEAR(n.norm(), 1, 1e-4);
        const Eigen::Vector3f eye =
            fused.sensors[fused.points.sensor[i]].camera_from_world.inverse().translation.cast<float>();
        ASSERT_GT(n.dot(eye - fused.points.positions[i]), 0);
        const Eigen::Vector3f& p = fused.points.positions[i];
        if (std::abs(p.z() - 1.0F) > 1e-3 || std::abs(p.x()) > 0.45 || p.y() < 0.35 || p.y() > 0.55) continue;
        ++top;
        good += n.z() > 0.98F;
    }
    EXPECT_GT(top, 100U);
    EXPECT_GT(good, 0.99 * static_cast<double>(top));
}

TEST(SurfaceFusion, NormalsDoNotCrossDepthEdges) {
    // A thin post before a wall: no normal may lie between the two.
    DepthScene scene;
    scene.boxes = {{{-0.03, 0.0, 0.05}, {0.03, 0.06, 1.5}}, {{-2, 1.5, 0.0}, {2, 1.6, 2.0}}};
    const Fused fused = fuse(scene, std::nullopt);
    for (size_t i = 0; i < fused.points.size(); ++i) {
        const Eigen::Vector3f& n = fused.points.normals[i];
        const Eigen::Vector3f& p = fused.points.positions[i];
        if (std::abs(p.y() - 1.5F) > 1e-3F || p.z() < 0.1F || p.z() > 1.9F || n.isZero()) continue;
        ASSERT_LT(n.y(), -0.9F);
    }
}

TEST(SurfaceFusion, CellAndFloorBoundThePoints) {
    DepthScene scene;
    scene.capsules = standing_person(0, 0);
    const Box cell{{-0.3, -0.3, 0.0}, {0.3, 0.3, 1.2}};
    const Fused fused = fuse(scene, cell);
    ASSERT_GT(fused.points.size(), 500U);
    for (const Eigen::Vector3f& p : fused.points.positions) {
        ASSERT_TRUE(cell.contains(p.cast<double>()));
        ASSERT_GE(p.z(), 0.03F);
    }
}

TEST(SurfaceFusion, ForegroundIsDenseAndTheRestIsThinned) {
    DepthScene scene;
    scene.capsules = standing_person(0, 0);
    SurfaceFusion::Params thin;
    thin.stride = 4;
    SurfaceFusion::Params full;
    full.stride = 1;
    const auto split = [](const SurfacePoints& points) {
        std::pair<size_t, size_t> counts;
        for (const uint8_t f : points.foreground) ++(f ? counts.first : counts.second);
        return counts;
    };
    full.floor_m = thin.floor_m = -0.1;
    const auto dense = split(fuse(scene, std::nullopt, full).points),
               sparse = split(fuse(scene, std::nullopt, thin).points);
    EXPECT_EQ(dense.first, sparse.first);
    EXPECT_GT(dense.first, 3000U);
    EXPECT_NEAR(static_cast<double>(dense.second) / static_cast<double>(sparse.second), 16, 1);
}

TEST(SurfaceFusion, OrderIsSensorBySensor) {
    DepthScene scene;
    scene.capsules = standing_person(0, 0);
    const Fused fused = fuse(scene, std::nullopt);
    EXPECT_TRUE(std::is_sorted(fused.points.sensor.begin(), fused.points.sensor.end()));
    EXPECT_EQ(fused.points.sensor.front(), 0);
    EXPECT_EQ(fused.points.sensor.back(), 1);
    EXPECT_EQ(fused.points.normals.size(), fused.points.size());
    EXPECT_EQ(fused.points.foreground.size(), fused.points.size());
}

TEST(SurfaceFusion, UglyFramesGiveNoPoints) {
    const auto sensors = two_sensors();
    ForegroundModel foreground(sensors, {}, {});
    SurfaceFusion fusion(sensors, std::nullopt, {});
    Frameset frameset = render_all(sensors, {}, 0);
    frameset.frames[0].present = false;
    frameset.frames[1].depth.resize(11, 3);
    foreground.update(frameset);
    EXPECT_EQ(fusion.update(frameset, foreground).size(), 0U);
    frameset = render_all(sensors, {}, 0);
    for (DepthFrame& frame : frameset.frames)
        std::fill(frame.depth.millimetres.begin(), frame.depth.millimetres.end(), 0);
    foreground.update(frameset);
    EXPECT_EQ(fusion.update(frameset, foreground).size(), 0U);
    EXPECT_EQ(fusion.update({}, foreground).size(), 0U);
    for (DepthFrame& frame : frameset.frames)
        std::fill(frame.depth.millimetres.begin(), frame.depth.millimetres.end(), uint16_t{65534});
    foreground.update(frameset);
    EXPECT_EQ(fusion.update(frameset, foreground).size(), 0U);
}

TEST(SurfaceFusion, ParamsNameWhatIsOutOfRange) {
    EXPECT_TRUE(SurfaceFusion::Params{}.validate().empty());
    SurfaceFusion::Params params;
    params.stride = 0;
    params.normal_reach = 100;
    params.max_depth_m = std::nan("");
    EXPECT_EQ(params.validate().size(), 3U);
}

}  // namespace
}  // namespace deixis
