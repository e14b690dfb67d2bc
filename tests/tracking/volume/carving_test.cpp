// Carving against the plain loop of algorithm 1, bit for bit, and the laws of eq. 3.3 and 3.4.
#include "tracking/volume/carving.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/tracking/volume/depth_scenes.h"
#include "tracking/volume/carving_kernel.h"

namespace deixis {
namespace {

/// Pixel index that the centre falls on, or -1. The arithmetic that carving_kernel.h promises, one voxel at a
/// time.
int64_t plain_pixel(const CarvingView& view, float x, float y, float z, float& depth) {
    const auto& p = view.camera_from_world;
    const float px = p[0] * x + (p[1] * y + (p[2] * z + p[3]));
    const float py = p[4] * x + (p[5] * y + (p[6] * z + p[7]));
    depth = p[8] * x + (p[9] * y + (p[10] * z + p[11]));
    if (!(depth > 0)) return -1;
    const float inverse = 1.0F / depth;
    float u = px * inverse, v = py * inverse;
    if (view.distorted) {
        const auto& k = view.distortion;
        const float r2 = u * u + v * v;
        if (!(r2 < view.max_radius2)) return -1;
        const float radial = 1.0F + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
        const float uv2 = 2.0F * (u * v);
        const float du = k[2] * uv2 + k[3] * (r2 + 2.0F * (u * u));
        const float dv = k[2] * (r2 + 2.0F * (v * v)) + k[3] * uv2;
        u = u * radial + du;
        v = v * radial + dv;
    }
    const float column = std::floor((view.fx * u + view.cx) + 0.5F),
                row = std::floor((view.fy * v + view.cy) + 0.5F);
    if (!(column >= 0 && column < static_cast<float>(view.width) && row >= 0 &&
          row < static_cast<float>(view.height)))
        return -1;
    return static_cast<int64_t>(row) * view.width + static_cast<int64_t>(column);
}

std::vector<uint8_t> plain_carve(const std::vector<const CarvingView*>& views, const VoxelLattice& lattice,
                                 const CarvingMargins& margins) {
    std::vector<uint8_t> states(lattice.size());
    for (size_t i = 0; i < states.size(); ++i) {
        const Eigen::Vector3i c = lattice.coordinates(i);
        const auto centre = [&](int axis) {
            return lattice.corner[axis] + lattice.side * (static_cast<float>(c[axis]) + 0.5F);
        };
        bool is_free = false, is_occupied = false;
        for (const CarvingView* view : views) {
            float d = 0;
            const int64_t pixel = plain_pixel(*view, centre(0), centre(1), centre(2), d);
            if (pixel < 0) continue;
            const float signed_depth = view->depth[pixel], depth = std::abs(signed_depth);
            if (!(depth > 0)) continue;
            const float slack = margins.slack_constant + margins.slack_per_m2 * (depth * depth);
            if (d < depth - slack)
                is_free = true;
            else if (d <= depth + margins.penetration && signed_depth > 0)
                is_occupied = true;
        }
        states[i] = static_cast<uint8_t>(is_free       ? VoxelState::free
                                         : is_occupied ? VoxelState::occupied
                                                       : VoxelState::unknown);
    }
    return states;
}

std::vector<const CarvingView*> pointers(const std::vector<CarvingView>& views) {
    std::vector<const CarvingView*> all;
    for (const CarvingView& view : views) all.push_back(&view);
    return all;
}

const Box carved_box{{-1.5, -1.2, 0.0}, {1.5, 1.2, 2.0}};

struct Carved {
    std::vector<CalibratedSensor> sensors;
    DepthScene empty, scene;
    Frameset frameset;
    VoxelGrid grid;
    std::vector<CarvingView> views;
    VoxelCarver::Params params;
};

Carved carve_person(std::vector<CalibratedSensor> sensors, double voxel = 0.05,
                    const SceneNoise& noise = {}) {
    Carved carved;
    carved.sensors = std::move(sensors);
    carved.params.voxel_m = voxel;
    carved.scene.capsules = standing_person(0.1, -0.2);
    std::vector<std::optional<DepthImage>> background;
    for (const auto& sensor : carved.sensors) background.emplace_back(render(sensor, carved.empty));
    ForegroundModel foreground(carved.sensors, background, {});
    carved.frameset = render_all(carved.sensors, carved.scene, 1000, noise);
    foreground.update(carved.frameset);
    VoxelCarver carver(carved.sensors, carved_box, carved.params);
    carved.grid = carver.update(carved.frameset, foreground);
    carved.views = carver.views();
    return carved;
}

CarvingMargins margins_of(const VoxelCarver::Params& p) {
    return {static_cast<float>(p.slack_m), static_cast<float>(p.slack_steps * p.step_per_m2),
            static_cast<float>(p.penetration_m)};
}

size_t count(const VoxelGrid& grid, VoxelState state) {
    return static_cast<size_t>(
        std::count(grid.states.begin(), grid.states.end(), static_cast<uint8_t>(state)));
}

TEST(Carving, EqualsThePlainLoopBitForBit) {
    const Carved carved = carve_person(two_sensors(), 0.04, {2.85e-3, 0.05, 3});
    EXPECT_EQ(carved.grid.states,
              plain_carve(pointers(carved.views), carved.grid.lattice, margins_of(carved.params)));
    EXPECT_GT(count(carved.grid, VoxelState::occupied), 300U);
    EXPECT_GT(count(carved.grid, VoxelState::free), 10000U);
    EXPECT_GT(count(carved.grid, VoxelState::unknown), 100U);
}

TEST(Carving, EqualsThePlainLoopThroughDistortedLenses) {
    std::vector<CalibratedSensor> sensors = two_sensors();
    sensors[0].camera.distortion = {-0.28, 0.09, 0.002, -0.001, 0.01};
    sensors[1].camera.distortion = {0.12, -0.05, -0.003, 0.002, 0.0};
    const Carved carved = carve_person(sensors, 0.04, {2.85e-3, 0.05, 4});
    EXPECT_EQ(carved.grid.states,
              plain_carve(pointers(carved.views), carved.grid.lattice, margins_of(carved.params)));
    EXPECT_GT(count(carved.grid, VoxelState::occupied), 300U);
}

TEST(Carving, EqualsThePlainLoopOnRandomViews) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int trial = 0; trial < 20; ++trial) {
        std::vector<CarvingView> views;
        std::vector<CalibratedSensor> sensors;
        for (int s = 0; s < 3; ++s) {
            CalibratedSensor sensor = sensor_looking({2 * unit(random), 2 * unit(random), 1 + unit(random)},
                                                     {unit(random), unit(random), 1}, 64 + trial, 48);
            sensor.camera.distortion = {0.3 * unit(random), 0.1 * unit(random), 0.01 * unit(random),
                                        0.01 * unit(random), 0};
            sensors.push_back(sensor);
        }
        const Box box{{-1, -1, 0},
                      {-1 + 0.031 * (trial + 1), 1, 2}};  // rows shorter and longer than a vector
        views = VoxelCarver(sensors, box, {}).views();
        for (CarvingView& view : views)
            for (float& depth : view.depth) {
                const double d = 3 * unit(random);
                depth = std::abs(d) < 0.3 ? 0.0F : static_cast<float>(d);
            }
        const VoxelLattice lattice = VoxelLattice::covering(box, 0.031);
        std::vector<uint8_t> states;
        carve(pointers(views), lattice, {0.01F, 0.003F, 0.2F}, states);
        ASSERT_EQ(states, plain_carve(pointers(views), lattice, {0.01F, 0.003F, 0.2F})) << trial;
    }
}

TEST(Carving, WhatASensorSeesThroughIsFreeAndTheBodyIsNot) {
    const Carved carved = carve_person(two_sensors());
    const auto state_at = [&](const Eigen::Vector3f& p) {
        return carved.grid.state(carved.grid.lattice.find(p));
    };
    EXPECT_EQ(state_at({0.9F, 0.2F, 1.0F}), VoxelState::free);
    EXPECT_EQ(state_at({-0.9F, -0.3F, 1.4F}), VoxelState::free);
    EXPECT_NE(state_at({0.1F, -0.2F, 1.1F}), VoxelState::free);  // inside the trunk
    size_t inside = 0, inside_free = 0;
    for (size_t i = 0; i < carved.grid.states.size(); ++i)
        for (const Capsule& c : carved.scene.capsules) {
            const Eigen::Vector3d p = carved.grid.lattice.centre(i).cast<double>();
            const Eigen::Vector3d ab = c.b - c.a;
            const double t = std::clamp((p - c.a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
            if ((p - c.a - t * ab).norm() > c.radius - 0.02) continue;
            ++inside;
            inside_free += carved.grid.state(i) == VoxelState::free;
            break;
        }
    EXPECT_GT(inside, 200U);
    EXPECT_EQ(inside_free, 0U);
}

TEST(Carving, OccupiedVoxelsLieWithinThePenetrationBehindTheSurface) {
    const Carved carved = carve_person({two_sensors()[0]});
    const RigidTransform camera_from_world = carved.sensors[0].camera_from_world;
    const CameraModel& camera = carved.sensors[0].camera;
    for (size_t i = 0; i < carved.grid.states.size(); ++i) {
        if (carved.grid.state(i) != VoxelState::occupied) continue;
        const Eigen::Vector3d p = camera_from_world * carved.grid.lattice.centre(i).cast<double>();
        const Eigen::Vector2d pixel = camera.project(p);
        const double depth =
            carved.frameset.frames[0].depth.at(static_cast<int>(std::floor(pixel.x() + 0.5)),
                                               static_cast<int>(std::floor(pixel.y() + 0.5))) /
            1000.0;
        ASSERT_LE(p.z(), depth + carved.params.penetration_m + 1e-3);
        ASSERT_GE(p.z(), depth - 0.06);
    }
}

TEST(Carving, ASecondViewOnlyTakesAway) {
    const std::vector<CalibratedSensor> both = two_sensors();
    const Carved one = carve_person({both[0]}), two = carve_person(both);
    for (size_t i = 0; i < one.grid.states.size(); ++i)
        if (one.grid.state(i) == VoxelState::free) {
            ASSERT_EQ(two.grid.state(i), VoxelState::free);
        }
}

TEST(Carving, TheOrderOfTheSensorsDoesNotMatter) {
    std::vector<CalibratedSensor> sensors = two_sensors();
    const Carved a = carve_person(sensors);
    std::swap(sensors[0], sensors[1]);
    EXPECT_EQ(a.grid.states, carve_person(sensors).grid.states);
}

TEST(Carving, NothingIsKnownWithoutMeasurement) {
    const std::vector<CalibratedSensor> sensors = two_sensors();
    ForegroundModel foreground(sensors, {}, {});
    VoxelCarver carver(sensors, carved_box, {});
    Frameset frameset = render_all(sensors, {}, 0);
    for (DepthFrame& frame : frameset.frames)
        std::fill(frame.depth.millimetres.begin(), frame.depth.millimetres.end(), 0);
    foreground.update(frameset);
    EXPECT_EQ(count(carver.update(frameset, foreground), VoxelState::unknown), carver.grid().lattice.size());
    for (DepthFrame& frame : frameset.frames) frame.present = false;
    foreground.update(frameset);
    EXPECT_EQ(count(carver.update(frameset, foreground), VoxelState::unknown), carver.grid().lattice.size());
    const Frameset nothing;
    foreground.update(nothing);
    EXPECT_EQ(count(carver.update(nothing, foreground), VoxelState::unknown), carver.grid().lattice.size());
}

TEST(Carving, NothingIsCarvedBehindTheCamera) {
    const std::vector<CalibratedSensor> sensors = {sensor_looking({0, 0, 1}, {1, 0, 1})};
    ForegroundModel foreground(sensors, {}, {});
    VoxelCarver carver(sensors, carved_box, {});
    Frameset frameset = render_all(sensors, {{}, {}, false}, 0);
    std::fill(frameset.frames[0].depth.millimetres.begin(), frameset.frames[0].depth.millimetres.end(),
              60000);
    foreground.update(frameset);
    const VoxelGrid& grid = carver.update(frameset, foreground);
    size_t carved = 0;
    for (size_t i = 0; i < grid.states.size(); ++i) {
        if (grid.lattice.centre(i).x() < 0) {
            ASSERT_EQ(grid.state(i), VoxelState::unknown);
        }
        carved += grid.state(i) == VoxelState::free;
    }
    EXPECT_GT(carved, 1000U);
}

TEST(Carving, ImagesOfAnotherSizeAreNotLookedAt) {
    const std::vector<CalibratedSensor> sensors = two_sensors();
    ForegroundModel foreground(sensors, {}, {});
    VoxelCarver carver(sensors, carved_box, {});
    Frameset frameset = render_all(sensors, {}, 0);
    frameset.frames[0].depth.resize(7, 5);
    frameset.frames[1].depth.resize(0, 0);
    foreground.update(frameset);
    EXPECT_EQ(count(carver.update(frameset, foreground), VoxelState::unknown), carver.grid().lattice.size());
}

TEST(Carving, ParamsNameWhatIsOutOfRange) {
    EXPECT_TRUE(VoxelCarver::Params{}.validate().empty());
    VoxelCarver::Params params;
    params.voxel_m = 0;
    params.penetration_m = std::nan("");
    const InvalidSettings complaints = params.validate();
    ASSERT_EQ(complaints.size(), 2U);
    EXPECT_EQ(complaints[0].key, "voxel_m");
    EXPECT_EQ(complaints[1].key, "penetration_m");
}

TEST(VoxelLattice, PositionsAndIndicesAreEachOthersInverse) {
    const VoxelLattice lattice = VoxelLattice::covering({{-1, 2, 0}, {0.33, 2.5, 1}}, 0.07);
    for (size_t i = 0; i < lattice.size(); ++i)
        ASSERT_EQ(lattice.find(lattice.centre(i)), static_cast<int64_t>(i));
    EXPECT_EQ(lattice.find({-1.01F, 2.1F, 0.1F}), -1);
    EXPECT_EQ(lattice.find({NAN, 2.1F, 0.1F}), -1);
    EXPECT_EQ(lattice.find({0, 2.1F, 99.0F}), -1);
    EXPECT_EQ(VoxelLattice::covering({{0, 0, 0}, {-1, 1, 1}}, 0.1).size(), 0U);
}

}  // namespace
}  // namespace deixis
