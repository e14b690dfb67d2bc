// The worker among part, trolley and noise, from rendered scenes through foreground, carving and fusion.
#include "tracking/volume/worker_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "tests/tracking/volume/depth_scenes.h"
#include "tracking/volume/carving.h"
#include "tracking/volume/surface_fusion.h"

namespace deixis {
namespace {

const Box cell{{-1.8, -1.5, 0.0}, {1.8, 1.5, 2.2}};
const Box trolley{{-0.8, 0.4, 0.0}, {0.8, 0.9, 0.7}};
const Box part{{-0.8, 0.4, 0.7}, {0.8, 0.6, 1.1}};

/// The stages before the worker, on scenes.
struct Pipeline {
    explicit Pipeline(std::vector<CalibratedSensor> rig = two_sensors())
        : sensors(std::move(rig)), carver(sensors, cell, {}), fusion(sensors, cell, {}), worker({}) {
        std::vector<std::optional<DepthImage>> background;
        for (const auto& sensor : sensors) background.emplace_back(render(sensor, {}));
        foreground = std::make_unique<ForegroundModel>(sensors, background, ForegroundModel::Params{});
    }

    const WorkerBody& see(const DepthScene& scene, int frame, bool know_part = true,
                          const SceneNoise& noise = {2.85e-3, 0.01, 1}) {
        return see(render_all(sensors, scene, 33'333LL * frame, noise), know_part);
    }

    const WorkerBody& see(const Frameset& frameset, bool know_part = true) {
        foreground->update(frameset);
        points = fusion.update(frameset, *foreground);
        carver.update(frameset, *foreground);
        part_points.assign(know_part ? points.size() : 0, 0);
        for (size_t i = 0; i < part_points.size(); ++i) {
            const Eigen::Vector3d p = points.positions[i].cast<double>();
            const Eigen::Vector3d nearest = p.cwiseMax(part.min).cwiseMin(part.max);
            part_points[i] = (p - nearest).norm() < 0.035;
        }
        return worker.update(frameset.timestamp_us, carver.grid(), points, part_points);
    }

    std::vector<CalibratedSensor> sensors;
    std::unique_ptr<ForegroundModel> foreground;
    VoxelCarver carver;
    SurfaceFusion fusion;
    WorkerVolume worker;
    SurfacePoints points;
    std::vector<uint8_t> part_points;
};

DepthScene person_at(double x, double y, double height = 1.75) {
    DepthScene scene;
    scene.capsules = standing_person(x, y, height);
    return scene;
}

size_t points_in(const Pipeline& pipeline, const WorkerBody& body, const Box& box) {
    return static_cast<size_t>(std::count_if(body.points.begin(), body.points.end(), [&](uint32_t i) {
        return box.contains(pipeline.points.positions[i].cast<double>());
    }));
}

TEST(WorkerVolume, APersonIsMeasured) {
    for (const double height : {1.55, 1.75, 1.98}) {
        Pipeline pipeline;
        const WorkerBody& body = pipeline.see(person_at(0.2, -0.3, height), 0);
        ASSERT_TRUE(body.present) << height;
        EXPECT_NEAR(body.head_top.z(), height, 0.06);
        EXPECT_NEAR(body.head_top.x(), 0.2, 0.08);
        EXPECT_NEAR(body.head_top.y(), -0.3, 0.12);
        EXPECT_NEAR(body.height, height, 0.06);
        EXPECT_GT(body.voxels.size(), 400U);
        EXPECT_GT(body.points.size(), 2000U);
        EXPECT_TRUE(std::is_sorted(body.voxels.begin(), body.voxels.end()));
        EXPECT_TRUE(std::is_sorted(body.points.begin(), body.points.end()));
    }
}

TEST(WorkerVolume, NobodyInAnEmptyCellAndInUglyFrames) {
    Pipeline pipeline;
    EXPECT_FALSE(pipeline.see(DepthScene{}, 0).present);
    Frameset dark = render_all(pipeline.sensors, {}, 40'000);
    for (DepthFrame& frame : dark.frames)
        std::fill(frame.depth.millimetres.begin(), frame.depth.millimetres.end(), 0);
    EXPECT_FALSE(pipeline.see(dark).present);
    dark.frames[0].present = dark.frames[1].present = false;
    EXPECT_FALSE(pipeline.see(dark).present);
    EXPECT_FALSE(pipeline.see(Frameset{80'000, {}}).present);
    EXPECT_TRUE(pipeline.worker.body().points.empty());
    EXPECT_TRUE(pipeline.worker.body().voxels.empty());
}

TEST(WorkerVolume, PartAndTrolleyAreNoPersonAndNotHis) {
    Pipeline pipeline;
    DepthScene scene;
    scene.boxes = {trolley, part};
    for (int k = 0; k < 20; ++k) EXPECT_FALSE(pipeline.see(scene, k).present) << k;
    EXPECT_FALSE(pipeline.worker.clutter().empty());
    // He comes and stands against the trolley.
    scene.capsules = standing_person(0.1, 0.24);
    const WorkerBody& body = pipeline.see(scene, 20);
    ASSERT_TRUE(body.present);
    const Box trolley_inside{{-0.8, 0.55, 0.0}, {0.8, 0.9, 1.1}};
    EXPECT_LT(points_in(pipeline, body, trolley_inside), body.points.size() / 50);
    EXPECT_GT(points_in(pipeline, body, {{-0.4, 0.0, 0.8}, {0.6, 0.38, 1.9}}), 1000U);
}

TEST(WorkerVolume, ABarThatHangsInTheAirIsAThing) {
    // The side bar of a trolley, seen long before the worker puts his hand beside it.
    Pipeline pipeline;
    const Capsule bar{{0.45, 0.1, 1.05}, {0.45, 0.6, 1.05}, 0.02};
    DepthScene scene;
    scene.capsules = {bar};
    for (int k = 0; k < 20; ++k) pipeline.see(scene, k, false);
    EXPECT_FALSE(pipeline.worker.clutter().empty());
    scene = person_at(0.2, -0.5);
    scene.capsules.push_back(bar);
    scene.capsules.push_back(stretched_arm(0.2, -0.5, 1.75, 1, {0.42, 0.2, 1.05}));
    const Box beyond_the_hand{{0.4, 0.3, 0.95}, {0.5, 0.6, 1.15}};
    for (int k = 20; k < 80; ++k) {  // he stays longer than an unseen thing is remembered
        const WorkerBody& body = pipeline.see(scene, k, false);
        ASSERT_TRUE(body.present) << k;
        EXPECT_LT(points_in(pipeline, body, beyond_the_hand), 10U) << k;  // of some hundred
    }
}

TEST(WorkerVolume, AThingThatLeftIsForgotten) {
    Pipeline pipeline;
    DepthScene scene;
    scene.boxes = {{{-0.3, -0.3, 0.0}, {0.3, 0.3, 0.8}}};
    for (int k = 0; k < 20; ++k) pipeline.see(scene, k, false);
    ASSERT_FALSE(pipeline.worker.clutter().empty());
    const size_t before = pipeline.worker.clutter().size();
    for (int k = 20; k < 100; ++k) pipeline.see(DepthScene{}, k, false);
    EXPECT_LT(pipeline.worker.clutter().size(), before / 20);
    EXPECT_TRUE(pipeline.see(person_at(0, 0), 100, false).present);
}

TEST(WorkerVolume, ALowThingAloneIsNobody) {
    Pipeline pipeline;
    DepthScene scene;
    scene.boxes = {{{-0.2, -0.2, 0.0}, {0.2, 0.2, 1.0}}};
    EXPECT_FALSE(pipeline.see(scene, 0, false).present);
    scene.boxes = {{{-1.2, -0.2, 0.0}, {1.2, 0.2, 1.5}}};  // a wall is wide
    EXPECT_FALSE(pipeline.see(scene, 1, false).present);
}

TEST(WorkerVolume, OneEyeIsEnough) {
    for (const size_t missing : {0U, 1U}) {
        Pipeline pipeline;
        Frameset frameset = render_all(pipeline.sensors, person_at(0, 0), 0, {2.85e-3, 0.01, 1});
        frameset.frames[missing].present = false;
        EXPECT_TRUE(pipeline.see(frameset).present);
    }
}

TEST(WorkerVolume, AForearmBehindAnEdgeIsHis) {
    Pipeline pipeline;
    DepthScene scene = person_at(0, -0.4);
    scene.capsules.push_back({{0.25, 0.16, 1.15}, {0.25, 0.45, 1.05}, 0.035});  // 20 cm off the trunk's front
    scene.capsules.push_back({{0.23, -0.35, 1.36}, {0.25, 0.06, 1.2}, 0.04});
    const WorkerBody& body = pipeline.see(scene, 0, false);
    ASSERT_TRUE(body.present);
    EXPECT_GT(points_in(pipeline, body, {{0.15, 0.2, 0.95}, {0.35, 0.5, 1.25}}), 50U);
}

TEST(WorkerVolume, StampsThatJumpBackStartAfresh) {
    Pipeline pipeline;
    DepthScene scene;
    scene.boxes = {trolley};
    for (int k = 100; k < 130; ++k) pipeline.see(scene, k, false);
    ASSERT_FALSE(pipeline.worker.clutter().empty());
    pipeline.see(scene, 0, false);
    EXPECT_TRUE(pipeline.worker.clutter().empty());
}

TEST(WorkerVolume, TheSameFramesGiveTheSameBody) {
    Pipeline a, b;
    DepthScene scene = person_at(0, 0);
    scene.boxes = {trolley, part};
    for (int k = 0; k < 5; ++k) {
        const WorkerBody& first = a.see(scene, k);
        const WorkerBody& second = b.see(scene, k);
        EXPECT_EQ(first.points, second.points);
        EXPECT_EQ(first.voxels, second.voxels);
    }
}

TEST(WorkerVolume, ParamsNameWhatIsOutOfRange) {
    EXPECT_TRUE(WorkerVolume::Params{}.validate().empty());
    WorkerVolume::Params params;
    params.max_height_m = 1.0;
    params.clutter_s = 0;
    EXPECT_EQ(params.validate().size(), 2U);
}

}  // namespace
}  // namespace deixis
