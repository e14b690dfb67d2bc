// A station without an image of its empty cell finds it out by itself.
#include "tracking/volume/live_background.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/tracking/volume/depth_scenes.h"

namespace deixis {
namespace {

constexpr SceneNoise kinect{2.85e-3, 0.01, 0};

size_t pixels_in(std::span<const uint8_t> mask) {
    return static_cast<size_t>(std::accumulate(mask.begin(), mask.end(), 0));
}

SceneNoise noise_of(uint32_t frame) {
    SceneNoise noise = kinect;
    noise.seed = frame;
    return noise;
}

/// A worker who walks through the cell.
DepthScene walking(uint32_t frame) {
    DepthScene scene;
    scene.capsules = standing_person(-1.0 + 0.02 * frame, -0.2);
    return scene;
}

TEST(LiveBackground, LearnsTheCellBehindAWalkingWorker) {
    const auto sensors = two_sensors();
    const std::vector<std::optional<DepthImage>> nothing(2);
    ForegroundModel foreground(sensors, nothing, {});
    LiveBackground background(sensors, nothing, {2, 8});
    uint32_t frame = 0;
    for (; !background.done(); ++frame) {
        ASSERT_LT(frame, 100U);
        const Frameset frameset = render_all(sensors, walking(6 * frame % 100), frame, noise_of(frame));
        background.update(frameset, foreground);
        foreground.update(frameset);
    }
    EXPECT_EQ(frame, 15U) << "eight images, two framesets apart";
    for (int k = 0; k < 8; ++k, ++frame)  // what a short stay left behind is forgotten
        foreground.update(render_all(sensors, {}, frame, noise_of(frame)));
    for (size_t s = 0; s < 2; ++s) EXPECT_LT(pixels_in(foreground.mask(s)), foreground.mask(s).size() / 500);
    DepthScene scene;
    scene.capsules = standing_person(0.3, -0.2);
    foreground.update(render_all(sensors, scene, frame, noise_of(frame)));
    for (size_t s = 0; s < 2; ++s) EXPECT_GT(pixels_in(foreground.mask(s)), 500U) << "and the worker is seen";
}

TEST(LiveBackground, LeavesAKnownBackgroundAndAnAbsentSensorAlone) {
    const auto sensors = two_sensors();
    const std::vector<std::optional<DepthImage>> one_known = {render(sensors[0], {}), std::nullopt};
    ForegroundModel foreground(sensors, one_known, {});
    const std::vector<float> before(foreground.background_mm(0).begin(), foreground.background_mm(0).end());
    LiveBackground background(sensors, one_known, {1, 3});
    Frameset frameset = render_all(sensors, walking(50), 0);
    frameset.frames[1].present = false;
    for (int k = 0; k < 10; ++k) background.update(frameset, foreground);
    EXPECT_FALSE(background.done());
    frameset.frames[1].present = true;
    for (int k = 0; k < 3; ++k) background.update(frameset, foreground);
    EXPECT_TRUE(background.done());
    EXPECT_TRUE(std::equal(before.begin(), before.end(), foreground.background_mm(0).begin()));
    EXPECT_GT(*std::max_element(foreground.background_mm(1).begin(), foreground.background_mm(1).end()), 0);
}

TEST(LiveBackground, ParamsAreChecked) {
    EXPECT_TRUE(LiveBackground::Params{}.validate().empty());
    EXPECT_EQ((LiveBackground::Params{0, 2}).validate().size(), 2U);
}

}  // namespace
}  // namespace deixis
