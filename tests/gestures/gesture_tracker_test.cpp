// From rendered capsule workers to marks: all perception stages but the part's pose, which is given.
#include "gestures/gesture_tracker.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/tracking/volume/depth_scenes.h"
#include "tracking/volume/carving.h"
#include "tracking/volume/foreground.h"
#include "tracking/volume/surface_fusion.h"
#include "tracking/volume/worker_volume.h"

namespace deixis {
namespace {

using Eigen::Vector3d;

const Box cell{{-1.8, -1.5, 0.0}, {1.8, 1.5, 2.2}};

/// A box as the part, in its own frame: 1.6 m wide, 0.1 m deep, 0.5 m high, its middle at the origin.
const Box part_box{{-0.8, -0.05, -0.25}, {0.8, 0.05, 0.25}};

SurfaceMesh mesh_of(const Box& box) {
    SurfaceMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.emplace_back(static_cast<float>(i & 1 ? box.max.x() : box.min.x()),
                                   static_cast<float>(i & 2 ? box.max.y() : box.min.y()),
                                   static_cast<float>(i & 4 ? box.max.z() : box.min.z()));
    mesh.triangles = {{0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2},
                      {1, 3, 7}, {1, 7, 5}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    return mesh;
}

/// A cell with one worker, one part and one pointing arm.
struct Cell {
    Vector3d part_place{0, 0.6, 0.95};
    double x = 0, y = -0.25, height = 1.75;
    std::vector<CalibratedSensor> sensors;
    std::optional<Vector3d> pointing_axis = Vector3d::UnitY();
    SceneNoise noise{2.85e-3, 0.01, 1};
    bool part_known = true, part_at_rest = true;
    std::optional<size_t> missing_sensor;
    bool with_trolley = false;

    Cell() {
        sensors = {sensor_looking({-1.9, -1.4, 2.5}, {0, 0.3, 0.9}, 480, 360),
                   sensor_looking({2.0, -1.2, 2.4}, {0, 0.3, 0.9}, 480, 360)};
    }

    DepthScene scene(std::optional<Vector3d> target, int side) const {
        DepthScene scene;
        scene.capsules = standing_person(x, y, height);
        for (const int s : {-1, 1}) {
            if (target && s == side) {
                const Vector3d spot = part_place + *target;
                Capsule arm = stretched_arm(x, y, height, s, spot, 0.39 * height);
                Capsule finger = arm;
                arm.b = arm.a + 0.9 * (arm.b - arm.a);
                finger.radius = 0.012;
                scene.capsules.push_back(arm);
                scene.capsules.push_back(finger);
            } else {
                const Vector3d shoulder(x + s * 0.14 * height, y, 0.78 * height);
                scene.capsules.push_back({shoulder, shoulder - Vector3d(-s * 0.05, 0, 0.39 * height), 0.035});
            }
        }
        scene.boxes.push_back({part_place + part_box.min, part_place + part_box.max});
        if (with_trolley) scene.boxes.push_back({{-0.75, 0.6, 0.0}, {0.75, 1.0, 0.68}});
        return scene;
    }
};

struct Seen {
    std::vector<Mark> marks;
    int rays = 0, frames = 0;
    PointingRay last_ray;
};

/// Plays the scenes one after the other, each for its seconds, at 15 frames a second.
struct Act {
    DepthScene scene;
    double seconds;
};
Seen play(const Cell& world, const std::vector<Act>& acts, GestureTracker::Params params = {}) {
    SensorRig rig;
    rig.sensors = world.sensors;
    rig.pointing_axis = world.pointing_axis;
    std::vector<std::optional<DepthImage>> background;
    for (const auto& sensor : world.sensors) background.emplace_back(render(sensor, {}));
    ForegroundModel foreground(world.sensors, background, {});
    VoxelCarver carver(world.sensors, cell, {});
    SurfaceFusion fusion(world.sensors, cell, {});
    WorkerVolume worker({});
    RayCaster surface;
    surface.add(mesh_of(part_box));
    surface.commit();
    GestureTracker tracker(rig, params);
    RigidTransform world_from_part;
    world_from_part.translation = world.part_place;

    Seen seen;
    std::vector<uint8_t> part_points;
    int k = 0;
    for (const Act& act : acts) {
        const Frameset exact = render_all(world.sensors, act.scene, 0);
        for (const int end = k + static_cast<int>(15 * act.seconds); k < end; ++k) {
            const int64_t now = 1'000'000 + 66'667LL * k;
            Frameset frameset = exact;
            frameset.timestamp_us = now;
            for (size_t s = 0; s < frameset.frames.size(); ++s) {
                SceneNoise noise = world.noise;
                noise.seed =
                    world.noise.seed * 1009 + static_cast<uint32_t>(2 * k) + static_cast<uint32_t>(s);
                frameset.frames[s].timestamp_us = now;
                frameset.frames[s].depth = with_noise(exact.frames[s].depth, noise);
            }
            if (world.missing_sensor) frameset.frames[*world.missing_sensor].present = false;
            foreground.update(frameset);
            const SurfacePoints& points = fusion.update(frameset, foreground);
            const VoxelGrid& grid = carver.update(frameset, foreground);
            part_points.assign(points.size(), 0);
            for (size_t i = 0; i < points.size(); ++i) {
                const Vector3d p = points.positions[i].cast<double>() - world.part_place;
                part_points[i] = (p - p.cwiseMax(part_box.min).cwiseMin(part_box.max)).norm() < 0.035;
            }
            const WorkerBody& body = worker.update(now, grid, points, part_points);
            GestureInput input{now, body, points, part_points, &surface, std::nullopt, false};
            if (world.part_known) {
                input.world_from_part = world_from_part;
                input.part_at_rest = world.part_at_rest;
            }
            const GestureOutput output = tracker.update(input);
            ++seen.frames;
            if (output.ray) ++seen.rays, seen.last_ray = *output.ray;
            if (output.mark) seen.marks.push_back(*output.mark);
        }
    }
    return seen;
}

Seen point_at(const Cell& world, const Vector3d& target, int side, double seconds = 1.6) {
    return play(world, {{world.scene(target, side), seconds}});
}

TEST(GestureTracker, AHeldPointIsOneMarkNearItsSpotWithItsArm) {
    const Vector3d front(0, -0.05, 0);
    for (const int side : {-1, 1})
        for (const Vector3d& target :
             {Vector3d(0.1, 0, 0.1), Vector3d(-0.3, 0, 0.0), Vector3d(0.4, 0, 0.15)}) {
            Cell world;
            world.noise.seed = static_cast<uint32_t>(10 * target.x() + 20 + side);
            GestureTracker::Params params;
            params.pointing.eye_weight = 0;  // the arm is straight from the shoulder
            const DepthScene scene = world.scene(target + front, side);
            const Seen seen = play(world, {{scene, 1.6}}, params);
            ASSERT_EQ(seen.marks.size(), 1U) << side << " " << target.transpose();
            // This arm stops farther off than workers do, whom the default prior on the gap knows.
            EXPECT_LT((seen.marks[0].spot.position - target - front).norm(), 0.08)
                << side << " " << target.transpose();
            params.pointing.closeness_m = 10;
            params.pointing.direction_sigma_deg = 5;
            const Seen far = play(world, {{scene, 1.6}}, params);
            ASSERT_EQ(far.marks.size(), 1U) << side << " " << target.transpose();
            EXPECT_LT((far.marks[0].spot.position - target - front).norm(), 0.06)
                << side << " " << target.transpose();
            EXPECT_EQ(seen.marks[0].arm, side > 0 ? ArmSide::right : ArmSide::left);
            EXPECT_GT(seen.marks[0].confidence, 0.5);
        }
}

TEST(GestureTracker, OtherBodiesPlacesAndNoAxis) {
    for (const double height : {1.55, 1.95}) {
        Cell world;
        world.height = height;
        world.x = 0.4;
        world.pointing_axis.reset();
        world.sensors = {sensor_looking({-1.2, -1.5, 2.3}, {0.2, 0.4, 0.9}, 480, 360),
                         sensor_looking({1.9, 0.2, 2.6}, {0.2, 0.3, 0.9}, 480, 360)};
        world.sensors[0].camera.distortion = {-0.1, 0.03, 0.001, -0.001, 0};
        EXPECT_EQ(point_at(world, {0.3, -0.05, 0.1}, 1).marks.size(), 1U) << height;
    }
}

TEST(GestureTracker, ATrolleyUnderThePartDoesNotMatter) {
    Cell world;
    world.with_trolley = true;
    const DepthScene alone = [&] {
        DepthScene scene = world.scene(std::nullopt, 0);
        scene.capsules.clear();
        return scene;
    }();
    const DepthScene pointing = world.scene(Vector3d(0.2, -0.05, 0.0), 1);
    const Seen seen = play(world, {{alone, 1.0}, {pointing, 1.6}});
    EXPECT_EQ(seen.marks.size(), 1U);
}

TEST(GestureTracker, AWorkerWhoDoesNotPointMakesNone) {
    const Cell world;
    const Seen seen = play(world, {{world.scene(std::nullopt, 0), 2}});
    EXPECT_TRUE(seen.marks.empty());
    EXPECT_EQ(seen.rays, 0);
}

TEST(GestureTracker, AHandAtTheHipMakesNone) {
    const Cell world;
    DepthScene scene = world.scene(std::nullopt, 0);
    scene.capsules.erase(scene.capsules.end() - 1);  // the right arm: shoulder, elbow out, hand at the hip
    const Vector3d shoulder(world.x + 0.14 * 1.75, world.y, 0.78 * 1.75),
        elbow(world.x + 0.42, world.y + 0.12, 1.12), hip(world.x + 0.2, world.y + 0.05, 0.98);
    scene.capsules.push_back({shoulder, elbow, 0.04});
    scene.capsules.push_back({elbow, hip, 0.035});
    EXPECT_TRUE(play(world, {{scene, 2}}).marks.empty());
}

TEST(GestureTracker, NoMarkWithoutARestingPart) {
    Cell world;
    world.part_at_rest = false;
    EXPECT_TRUE(point_at(world, {0.1, -0.05, 0.1}, 1).marks.empty());
    world.part_known = false;
    EXPECT_TRUE(point_at(world, {0.1, -0.05, 0.1}, 1).marks.empty());
}

TEST(GestureTracker, TooShortAHoldMakesNone) {
    const Cell world;
    const DepthScene rest = world.scene(std::nullopt, 0), point = world.scene(Vector3d(0.1, -0.05, 0.1), 1);
    const Seen seen = play(world, {{rest, 0.8}, {point, 0.7}, {rest, 1.0}});
    EXPECT_TRUE(seen.marks.empty());
    EXPECT_GT(seen.rays, 5);
}

TEST(GestureTracker, OneEyeIsEnough) {
    Cell world;
    world.missing_sensor = 0;  // the right arm is seen by the right sensor
    EXPECT_EQ(point_at(world, {0.2, -0.05, 0.1}, 1, 2.0).marks.size(), 1U);
}

TEST(GestureTracker, UglyFramesMakeNoRay) {
    const Cell world;
    DepthScene nothing;
    nothing.floor = false;
    const Seen seen = play(world, {{nothing, 1.2}});
    EXPECT_EQ(seen.rays, 0);
    EXPECT_TRUE(seen.marks.empty());
    // Half a body: only what reaches above the waist.
    DepthScene half = world.scene(std::nullopt, 0);
    for (Capsule& c : half.capsules) c.a.z() = std::max(c.a.z(), 1.0), c.b.z() = std::max(c.b.z(), 1.0);
    EXPECT_TRUE(play(world, {{half, 1.2}}).marks.empty());
}

TEST(GestureTracker, TheSameFramesGiveTheSameMarks) {
    const Cell world;
    const Seen a = point_at(world, {0.1, -0.05, 0.1}, 1), b = point_at(world, {0.1, -0.05, 0.1}, 1);
    ASSERT_EQ(a.marks.size(), b.marks.size());
    for (size_t k = 0; k < a.marks.size(); ++k) {
        EXPECT_EQ(a.marks[k].timestamp_us, b.marks[k].timestamp_us);
        EXPECT_EQ(a.marks[k].spot.position, b.marks[k].spot.position);
    }
    EXPECT_EQ(a.last_ray.direction, b.last_ray.direction);
}

TEST(GestureTracker, ParamsOfAllStagesAreChecked) {
    EXPECT_TRUE(GestureTracker::Params{}.validate().empty());
    GestureTracker::Params params;
    params.stillness.dwell_s = 0;
    params.pointing.eye_weight = 2;
    params.pointing.touch_m = -1;
    params.pointing.max_reach_m = 0;
    params.limbs.min_length_m = 0;
    EXPECT_EQ(params.validate().size(), 5U);
}

}  // namespace
}  // namespace deixis
