// The empty cell learned from sessions in which it is never shown empty.
#include "tracking/volume/background_learner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/tracking/volume/depth_scenes.h"

namespace deixis {
namespace {

CalibratedSensor sensor() {
    return sensor_looking({0, -2, 2.2}, {0, 0.3, 0.8}, 160, 120);
}

/// Of the pixels that the truth knows: share within two disparity steps and 1 cm, share that stayed unknown.
std::pair<double, double> compare(const DepthImage& learned, const DepthImage& truth) {
    double known = 0, good = 0, unknown = 0;
    for (size_t i = 0; i < truth.millimetres.size(); ++i) {
        if (truth.millimetres[i] == 0) continue;
        ++known;
        const double z = truth.millimetres[i] / 1000.0;
        unknown += learned.millimetres[i] == 0;
        good += std::abs(learned.millimetres[i] - truth.millimetres[i]) <= 10 + 2 * 2.85 * z * z;
    }
    return {good / known, unknown / known};
}

std::vector<DepthImage> session(const CalibratedSensor& camera) {
    std::vector<DepthImage> images;
    for (uint32_t k = 0; k < 60; ++k) {
        DepthScene scene;  // walks across, stands for half of the session
        const double x = k < 30 ? -1.2 + 0.04 * k : 0.0;
        scene.capsules = standing_person(x, 0.2);
        images.push_back(render(camera, scene, {2.85e-3, 0.03, 500 + k}));
    }
    return images;
}

TEST(BackgroundLearner, SeesThroughAPersonWhoWalksIn) {
    BackgroundLearner learner({sensor()}, {});
    for (const DepthImage& image : session(sensor())) learner.add(0, image);
    const auto images = learner.background();
    ASSERT_EQ(images.size(), 1U);
    ASSERT_TRUE(images[0]);
    const auto [good, unknown] = compare(*images[0], render(sensor(), {}));
    EXPECT_GT(good, 0.995);
    EXPECT_EQ(unknown, 0);
}

TEST(BackgroundLearner, TheOrderOfTheImagesMattersOnlyWithinTheNoise) {
    std::vector<DepthImage> images = session(sensor());
    BackgroundLearner forwards({sensor()}, {}), shuffled({sensor()}, {});
    for (const DepthImage& image : images) forwards.add(0, image);
    std::shuffle(images.begin(), images.end(), std::mt19937(3));
    for (const DepthImage& image : images) shuffled.add(0, image);
    EXPECT_GT(compare(*forwards.background()[0], *shuffled.background()[0]).first, 0.995);
}

TEST(BackgroundLearner, AFlyingPixelIsNoBackground) {
    CalibratedSensor one = sensor_looking({0, 0, 1}, {0, 1, 1}, 2, 1);
    BackgroundLearner learner({one}, {});
    DepthImage image;
    image.resize(2, 1);
    for (int k = 0; k < 100; ++k) {
        image.millimetres = {2000, static_cast<uint16_t>(k < 2 ? 5000 : 2000)};
        learner.add(0, image);
    }
    EXPECT_EQ(learner.background()[0]->millimetres, (std::vector<uint16_t>{2000, 2000}));
}

TEST(BackgroundLearner, TheFarthestSupportedDepthWins) {
    CalibratedSensor one = sensor_looking({0, 0, 1}, {0, 1, 1}, 1, 1);
    BackgroundLearner learner({one}, {});
    DepthImage image;
    image.resize(1, 1);
    for (int k = 0; k < 100; ++k) {  // ten different things before it, the wall seen six times
        image.millimetres = {static_cast<uint16_t>(k % 16 == 7 ? 3600 : 1000 + 200 * (k % 10))};
        learner.add(0, image);
    }
    EXPECT_EQ(learner.background()[0]->millimetres[0], 3600);
}

TEST(BackgroundLearner, UnmeasuredPixelsAndUnseenSensorsStayUnknown) {
    const std::vector<CalibratedSensor> sensors = {sensor(), sensor()};
    BackgroundLearner learner(sensors, {});
    DepthImage image;
    image.resize(160, 120);
    learner.add(0, image);
    image.resize(3, 3);
    learner.add(1, image);
    learner.add(7, image);
    const auto images = learner.background();
    ASSERT_EQ(images.size(), 2U);
    ASSERT_TRUE(images[0]);
    EXPECT_EQ(*std::max_element(images[0]->millimetres.begin(), images[0]->millimetres.end()), 0);
    EXPECT_FALSE(images[1]);
}

TEST(BackgroundLearner, ParamsNameWhatIsOutOfRange) {
    EXPECT_TRUE(BackgroundLearner::Params{}.validate().empty());
    BackgroundLearner::Params params;
    params.support_frames = 0;
    params.support_share = 1.5;
    EXPECT_EQ(params.validate().size(), 2U);
}

}  // namespace
}  // namespace deixis
