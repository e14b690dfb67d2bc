// Foreground against known scenes: what is new is found, what is known is not, noise and moved things
// included.
#include "tracking/volume/foreground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/tracking/volume/depth_scenes.h"

namespace deixis {
namespace {

constexpr double kKinectStep = 2.85e-3;

size_t count(std::span<const uint8_t> mask) {
    return static_cast<size_t>(std::accumulate(mask.begin(), mask.end(), 0));
}

DepthImage flat(int width, int height, uint16_t mm) {
    DepthImage image;
    image.resize(width, height);
    std::fill(image.millimetres.begin(), image.millimetres.end(), mm);
    return image;
}

CalibratedSensor small_sensor(int width = 40, int height = 30) {
    return sensor_looking({0, 0, 2}, {0, 2, 0}, width, height);
}

Frameset single(const DepthImage& image, int64_t timestamp_us = 0) {
    Frameset frameset{timestamp_us, {}};
    frameset.frames.push_back({true, timestamp_us, 0, image});
    return frameset;
}

void paint(DepthImage& image, int u0, int v0, int u1, int v1, uint16_t mm) {
    for (int v = v0; v < v1; ++v)
        for (int u = u0; u < u1; ++u) image.millimetres[static_cast<size_t>(v) * image.width + u] = mm;
}

TEST(Foreground, AnEmptyCellHasNoneInSpiteOfTheNoise) {
    const auto sensors = two_sensors();
    std::vector<std::optional<DepthImage>> background;
    for (const auto& sensor : sensors) background.emplace_back(render(sensor, {}, {kKinectStep, 0.02, 99}));
    ForegroundModel model(sensors, background, {});
    for (uint32_t k = 0; k < 20; ++k) {
        model.update(render_all(sensors, {}, k, {kKinectStep, 0.02, k}));
        for (size_t s = 0; s < 2; ++s) EXPECT_LT(count(model.mask(s)), model.mask(s).size() / 1000) << k;
    }
}

TEST(Foreground, APersonIsFoundAndNothingElse) {
    const auto sensors = two_sensors();
    std::vector<std::optional<DepthImage>> background;
    for (const auto& sensor : sensors) background.emplace_back(render(sensor, {}));
    ForegroundModel model(sensors, background, {});
    DepthScene scene;
    scene.capsules = standing_person(0, -0.2);
    const Frameset frameset = render_all(sensors, scene, 1, {kKinectStep, 0.01, 5});
    model.update(frameset);
    for (size_t s = 0; s < 2; ++s) {
        size_t person = 0, found = 0, wrong = 0;
        const DepthImage clean = render(sensors[s], scene);
        for (size_t i = 0; i < clean.millimetres.size(); ++i) {
            // Half a metre before the floor is surely the person; feet are within the noise of the floor.
            const bool is_person = clean.millimetres[i] + 500 < background[s]->millimetres[i] ||
                                   (background[s]->millimetres[i] == 0 && clean.millimetres[i] != 0);
            const bool is_floor = clean.millimetres[i] == background[s]->millimetres[i];
            person += is_person;
            found += is_person && model.mask(s)[i];
            wrong += is_floor && model.mask(s)[i];
        }
        EXPECT_GT(person, 500U);
        EXPECT_GT(static_cast<double>(found), 0.93 * static_cast<double>(person));
        EXPECT_LT(wrong, 30U);
    }
}

TEST(Foreground, TheThresholdGrowsWithTheNoise) {
    for (const int near : {1000, 2000, 4000}) {
        const double step = 1000 * kKinectStep * near / 1000.0 * near / 1000.0;
        ForegroundModel::Params params;
        const double threshold = params.base_mm + params.threshold_steps * step;
        ForegroundModel model({small_sensor()}, {flat(40, 30, static_cast<uint16_t>(near))}, params);
        DepthImage image = flat(40, 30, static_cast<uint16_t>(near));
        paint(image, 5, 5, 15, 15, static_cast<uint16_t>(near - threshold + 3));
        paint(image, 20, 5, 30, 15, static_cast<uint16_t>(near - threshold - 3));
        model.update(single(image));
        EXPECT_EQ(count(model.mask(0)), 100U) << near;
        EXPECT_EQ(model.mask(0)[10 * 40 + 25], 1) << near;
    }
}

TEST(Foreground, SpecklesAndFlyingPixelsAreDropped) {
    ForegroundModel model({small_sensor()}, {flat(40, 30, 3000)}, {});
    DepthImage image = flat(40, 30, 3000);
    image.millimetres[10 * 40 + 10] = 1500;
    image.millimetres[20 * 40 + 20] = 1500;
    image.millimetres[20 * 40 + 21] = 1500;
    paint(image, 25, 5, 35, 15, 1500);
    for (int v = 5; v < 15; ++v)
        image.millimetres[static_cast<size_t>(v) * 40 + 24] = static_cast<uint16_t>(1700 + 97 * v);
    model.update(single(image));
    EXPECT_EQ(count(model.mask(0)), 100U);
}

TEST(Foreground, WhatMovedAwayUncoversTheBackground) {
    // A trolley stood there when the background was taken; now it is gone, then a person stands in its place.
    DepthImage with_trolley = flat(40, 30, 3500);
    paint(with_trolley, 10, 10, 20, 20, 2500);
    ForegroundModel model({small_sensor()}, {with_trolley}, {});
    const DepthImage empty = flat(40, 30, 3500);
    for (int k = 0; k < 10; ++k) model.update(single(empty, k));
    EXPECT_EQ(count(model.mask(0)), 0U);
    EXPECT_FLOAT_EQ(model.background_mm(0)[15 * 40 + 15], 3500);
    DepthImage person = empty;
    paint(person, 10, 10, 20, 20, 2600);  // behind where the trolley was
    model.update(single(person, 11));
    EXPECT_EQ(count(model.mask(0)), 100U);
}

TEST(Foreground, OneFarMeasurementDoesNotReplaceTheBackground) {
    ForegroundModel model({small_sensor()}, {flat(40, 30, 2500)}, {});
    for (int k = 0; k < 40; ++k) model.update(single(flat(40, 30, k % 8 == 0 ? 3500 : 2500), k));
    EXPECT_NEAR(model.background_mm(0)[100], 2500, 1);
}

TEST(Foreground, SlowDriftIsFollowed) {
    ForegroundModel model({small_sensor()}, {flat(40, 30, 2500)}, {});
    for (int k = 0; k < 3000; ++k) {
        model.update(single(flat(40, 30, static_cast<uint16_t>(2500 - k / 30)), k));
        ASSERT_EQ(count(model.mask(0)), 0U) << k;
    }
}

TEST(Foreground, AStandingPersonNeverBecomesBackground) {
    ForegroundModel model({small_sensor()}, {flat(40, 30, 3500)}, {});
    DepthImage image = flat(40, 30, 3500);
    paint(image, 10, 5, 20, 25, 2400);
    for (int k = 0; k < 3000; ++k) model.update(single(image, k));
    EXPECT_EQ(count(model.mask(0)), 200U);
}

TEST(Foreground, UnknownIsNotEmpty) {
    // A wide unknown area: what is measured there counts. A small hole: filled from around it.
    DepthImage background = flat(40, 30, 3000);
    paint(background, 0, 0, 40, 20, 0);
    paint(background, 30, 24, 33, 27, 0);
    ForegroundModel model({small_sensor()}, {background}, {});
    const DepthImage image = flat(40, 30, 3000);
    model.update(single(image));
    EXPECT_EQ(model.mask(0)[5 * 40 + 20], 1);
    EXPECT_EQ(model.mask(0)[25 * 40 + 31], 0);
    EXPECT_EQ(model.mask(0)[25 * 40 + 10], 0);
}

TEST(Foreground, WithoutMeasurementNothingIsForeground) {
    ForegroundModel model({small_sensor()}, {flat(40, 30, 3000)}, {});
    model.update(single(flat(40, 30, 0)));
    EXPECT_EQ(count(model.mask(0)), 0U);
    ForegroundModel unknown({small_sensor()}, {}, {});
    unknown.update(single(flat(40, 30, 0)));
    EXPECT_EQ(count(unknown.mask(0)), 0U);
}

TEST(Foreground, MissingSensorsAndWrongSizesGiveEmptyMasks) {
    const std::vector<CalibratedSensor> sensors = {small_sensor(), small_sensor(20, 16)};
    ForegroundModel model(sensors, {flat(40, 30, 3000), flat(9, 9, 3000)}, {});
    Frameset frameset = single(flat(40, 30, 1000));
    model.update(frameset);
    EXPECT_EQ(count(model.mask(0)), 1200U);
    EXPECT_EQ(model.mask(1).size(), 320U);
    EXPECT_EQ(count(model.mask(1)), 0U);
    frameset.frames[0].present = false;
    model.update(frameset);
    EXPECT_EQ(count(model.mask(0)), 0U);
    frameset.frames[0].present = true;
    frameset.frames[0].depth.resize(640, 480);
    model.update(frameset);
    EXPECT_EQ(count(model.mask(0)), 0U);
}

TEST(Foreground, ParamsNameWhatIsOutOfRange) {
    EXPECT_TRUE(ForegroundModel::Params{}.validate().empty());
    ForegroundModel::Params params;
    params.base_mm = -1;
    params.moved_frames = 0;
    params.drift_rate = std::nan("");
    params.neighbours = 9;
    EXPECT_EQ(params.validate().size(), 4U);
}

}  // namespace
}  // namespace deixis
