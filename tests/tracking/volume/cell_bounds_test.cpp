// The cell when the calibration names none.
#include "tracking/volume/cell_bounds.h"

#include <gtest/gtest.h>

#include "tests/tracking/volume/depth_scenes.h"

namespace deixis {
namespace {

DepthScene walled() {
    DepthScene scene;
    scene.boxes = {
        {{-2.2, 1.9, 0}, {2.2, 2.0, 2.5}}, {{-2.3, -2, 0}, {-2.2, 2, 2.5}}, {{2.2, -2, 0}, {2.3, 2, 2.5}}};
    return scene;
}

TEST(CellBounds, TheCalibrationComesFirst) {
    SensorRig rig;
    rig.sensors = two_sensors();
    rig.cell = Box{{-1, -2, 0}, {3, 4, 2}};
    const Box box = cell_bounds(rig, rig.sensors, {});
    EXPECT_EQ(box.min, rig.cell->min);
    EXPECT_EQ(box.max, rig.cell->max);
}

TEST(CellBounds, WithoutOneTheBackgroundBoundsIt) {
    SensorRig rig;
    rig.sensors = {sensor_looking({-1.9, -1.4, 2.5}, {0.3, 1.0, 0.6}),
                   sensor_looking({2.0, -1.2, 2.4}, {-0.3, 1.0, 0.6})};
    std::vector<std::optional<DepthImage>> background;
    for (const auto& sensor : rig.sensors)
        background.emplace_back(render(sensor, walled(), {2.85e-3, 0.05, 1}));
    const Box box = cell_bounds(rig, rig.sensors, background);
    EXPECT_TRUE(box.contains({0, 0, 1}));
    EXPECT_TRUE(box.contains({1, 1, 2}));
    EXPECT_LT(box.max.x(), 2.6);
    EXPECT_GT(box.min.x(), -2.6);
    EXPECT_LT(box.max.y(), 2.3);
    EXPECT_EQ(box.min.z(), 0);
    EXPECT_NEAR(box.max.z(), 2.3, 0.2);
}

TEST(CellBounds, WithoutBackgroundTheViewsBoundIt) {
    SensorRig rig;
    rig.sensors = two_sensors();
    for (const std::vector<std::optional<DepthImage>>& none :
         {std::vector<std::optional<DepthImage>>{}, std::vector<std::optional<DepthImage>>(2)}) {
        const Box box = cell_bounds(rig, rig.sensors, none);
        for (const Eigen::Vector3d& p :
             {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.8, 0.8, 1), Eigen::Vector3d(-0.8, 0.8, 0.5)})
            EXPECT_TRUE(box.contains(p));
        EXPECT_LE((box.max - box.min).head<2>().maxCoeff(), 8.0);
    }
}

TEST(CellBounds, NothingAtAllIsAPlainCell) {
    const Box box = cell_bounds({}, {}, {});
    EXPECT_TRUE(box.contains({0, 0, 1}));
    EXPECT_DOUBLE_EQ((box.max - box.min).x(), 4);
}

TEST(CellBounds, BackgroundsOfAnotherSizeOrEmptyAreNotLookedAt) {
    SensorRig rig;
    rig.sensors = two_sensors();
    DepthImage wrong, empty;
    wrong.resize(8, 8);
    empty.resize(320, 240);
    const Box views = cell_bounds(rig, rig.sensors, {});
    const Box box = cell_bounds(rig, rig.sensors, {wrong, empty});
    EXPECT_EQ(box.min, views.min);
    EXPECT_EQ(box.max, views.max);
}

}  // namespace
}  // namespace deixis
