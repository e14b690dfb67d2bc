// Depth layers against geometry that is known in closed form.
#include "appliance/simulation/depth_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "appliance/simulation/cell_scenery.h"

namespace deixis {
namespace {

/// Looks along +y from the origin, 1 m above the floor, with a lens.
CalibratedSensor level_sensor() {
    CalibratedSensor sensor;
    sensor.camera = {160, 120, 145, 146, 80, 60, {-0.08, 0.03, 0.001, -0.001, 0.002}};
    Eigen::Matrix3d world_from_camera;
    world_from_camera << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    sensor.camera_from_world = RigidTransform{world_from_camera, {0, 0, 1}}.inverse();
    return sensor;
}

RayCaster caster_of(const SurfaceMesh& mesh) {
    RayCaster caster;
    caster.add(mesh);
    caster.commit();
    return caster;
}

TEST(DepthView, AWallHasItsDepthInEveryDistortedPixel) {
    const DepthView view(level_sensor());
    const RayCaster wall = caster_of(box_mesh({-9, 2, -9}, {9, 3, 9}));
    DepthLayer layer = view.empty_layer();
    view.overlay(layer, {&wall, {}}, {}, view.whole());
    for (size_t i = 0; i < layer.z.size(); ++i) {
        ASSERT_NEAR(layer.z[i], 2, 1e-4);
        ASSERT_EQ(layer.shaded[i], 0);
    }
    EXPECT_NEAR(layer.cosine[60 * 160 + 80], 1, 1e-3);
}

TEST(DepthView, MovedObjectEqualsMovedMesh) {
    const DepthView view(level_sensor());
    const RigidTransform to{Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                            {0.2, 2, 0.8}};
    const RayCaster at_origin = caster_of(box_mesh({-0.3, -0.1, -0.2}, {0.3, 0.1, 0.2}));
    const RayCaster moved = caster_of(box_mesh({-0.3, -0.1, -0.2}, {0.3, 0.1, 0.2}, to));
    DepthLayer a = view.empty_layer(), b = view.empty_layer();
    view.overlay(a, {&at_origin, to}, {}, view.whole());
    view.overlay(b, {&moved, {}}, {}, view.whole());
    size_t hits = 0;
    for (size_t i = 0; i < a.z.size(); ++i) {
        ASSERT_EQ(std::isfinite(a.z[i]), std::isfinite(b.z[i])) << i;
        if (!std::isfinite(a.z[i])) continue;
        ++hits;
        ASSERT_NEAR(a.z[i], b.z[i], 1e-4);
    }
    EXPECT_GT(hits, 500U);
}

TEST(DepthView, ShadowFallsToTheLeftByTheDisparity) {
    const CalibratedSensor sensor = level_sensor();
    const DepthView view(sensor, 0.075);
    const RayCaster wall = caster_of(box_mesh({-9, 3, -9}, {9, 4, 9}));
    const SurfaceMesh post_mesh = box_mesh({-0.2, 1.0, -5}, {0.2, 1.01, 5});
    const RayCaster post = caster_of(post_mesh);
    DepthLayer layer = view.empty_layer();
    view.overlay(layer, {&wall, {}}, {}, view.whole());
    view.overlay(layer, {&post, {}}, {{&wall, {}}}, view.whole());  // all its corners are out of view
    const int v = 60;
    int shaded = 0, first_post = 160, last_shaded = -1;
    for (int u = 0; u < 160; ++u) {
        const size_t i = static_cast<size_t>(v) * 160 + u;
        if (layer.shaded[i] != 0) {
            ++shaded;
            last_shaded = u;
            EXPECT_NEAR(layer.z[i], 3, 1e-3) << "only the wall is in shadow";
        }
        if (layer.z[i] < 2) first_post = std::min(first_post, u);
    }
    EXPECT_EQ(last_shaded, first_post - 1);
    EXPECT_NEAR(shaded, 145 * 0.075 * (1 / 1.0 - 1 / 3.0), 1.5);
}

TEST(DepthView, FootprintHoldsAllThatChanges) {
    const DepthView view(level_sensor());
    const RayCaster wall = caster_of(box_mesh({-9, 3, -9}, {9, 4, 9}));
    DepthLayer base = view.empty_layer();
    view.overlay(base, {&wall, {}}, {}, view.whole());
    for (const double x : {-1.2, -0.3, 0.0, 0.8, 1.6}) {
        const SurfaceMesh mesh = cylinder_mesh({x, 1.5, 0.2}, {x + 0.2, 2.2, 1.7}, 0.15);
        const RayCaster caster = caster_of(mesh);
        DepthLayer all = base, some = base;
        view.overlay(all, {&caster, {}}, {{&wall, {}}}, view.whole());
        view.overlay(some, {&caster, {}}, {{&wall, {}}}, view.footprint(mesh.vertices, {}));
        EXPECT_EQ(all.z, some.z) << x;
        EXPECT_EQ(all.shaded, some.shaded) << x;
    }
}

TEST(DepthView, WhatLiesBehindTheSensorHasNoFootprint) {
    const DepthView view(level_sensor());
    EXPECT_TRUE(view.footprint(box_mesh({-1, -3, 0}, {1, -2, 2}).vertices, {}).empty());
}

}  // namespace
}  // namespace deixis
