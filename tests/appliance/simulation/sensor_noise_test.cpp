// The sensor's noise against the figures of its sources.
#include "appliance/simulation/sensor_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

namespace deixis {
namespace {

constexpr int width = 320, height = 240;

DepthLayer plane(float z, float cosine) {
    const size_t count = static_cast<size_t>(width) * height;
    return {std::vector<float>(count, z), std::vector<float>(count, cosine), std::vector<uint8_t>(count, 0)};
}

DepthImage noisy(const SensorNoiseParams& params, const DepthLayer& layer, uint64_t seed = 1,
                 uint64_t frame = 0) {
    DepthImage image;
    SensorNoise(params).apply(seed, frame, layer, width, height, image);
    return image;
}

TEST(SensorNoise, StepsAreThoseOfAKinect) {
    DepthLayer ramp = plane(1, 1);
    for (size_t i = 0; i < ramp.z.size(); ++i)
        ramp.z[i] = 1.0F + 3.0F * static_cast<float>(i) / static_cast<float>(ramp.z.size());
    const DepthImage image = noisy({}, ramp);
    std::set<uint16_t> distinct(image.millimetres.begin(), image.millimetres.end());
    distinct.erase(0);
    std::vector<double> spacing;
    for (auto a = distinct.begin(), b = std::next(a); b != distinct.end(); ++a, ++b) {
        const double z = 0.0005 * (*a + *b);
        spacing.push_back(0.001 * (*b - *a) / (z * z));
    }
    std::nth_element(spacing.begin(), spacing.begin() + spacing.size() / 2, spacing.end());
    EXPECT_NEAR(spacing[spacing.size() / 2], 2.85e-3, 0.05e-3);
}

TEST(SensorNoise, SpreadAlongTheAxisIsThePublishedOne) {
    for (const float z : {1.3F, 2.0F, 2.7F})
        for (const double degrees : {20.0, 70.0}) {
            const double angle = degrees * std::numbers::pi / 180;
            const DepthImage image = noisy({}, plane(z, static_cast<float>(std::cos(angle))));
            double sum = 0, squares = 0;
            size_t count = 0;
            for (const uint16_t mm : image.millimetres) {
                if (mm == 0) continue;
                const double error = 0.001 * mm - static_cast<double>(z);
                sum += error;
                squares += error * error;
                ++count;
            }
            ASSERT_GT(count, image.millimetres.size() * 99 / 100);
            const double mean = sum / static_cast<double>(count);
            const double sigma = std::sqrt(squares / static_cast<double>(count));
            EXPECT_NEAR(sigma / axial_sigma(static_cast<double>(z), angle), 1, 0.12)
                << z << " m, " << degrees;
            EXPECT_LT(std::abs(mean), 0.2 * sigma) << "no bias to speak of";
        }
}

TEST(SensorNoise, NothingReturnsFromShadowGrazingAnglesOrOutOfRange) {
    const auto share = [](const DepthImage& image) {
        const auto seen = std::count_if(image.millimetres.begin(), image.millimetres.end(),
                                        [](uint16_t mm) { return mm != 0; });
        return static_cast<double>(seen) / static_cast<double>(image.millimetres.size());
    };
    const auto cosine = [](double degrees) {
        return static_cast<float>(std::cos(degrees * std::numbers::pi / 180));
    };
    EXPECT_GT(share(noisy({}, plane(2, cosine(70)))), 0.99);
    EXPECT_NEAR(share(noisy({}, plane(2, cosine(80)))), 0.5, 0.1);
    EXPECT_EQ(share(noisy({}, plane(2, cosine(85)))), 0);
    EXPECT_EQ(share(noisy({}, plane(0.3F, 1))), 0);
    EXPECT_EQ(share(noisy({}, plane(5, 1))), 0);
    EXPECT_EQ(share(noisy({}, plane(std::numeric_limits<float>::infinity(), 1))), 0);
    DepthLayer shaded = plane(2, 1);
    std::fill(shaded.shaded.begin(), shaded.shaded.end(), uint8_t{1});
    EXPECT_EQ(share(noisy({}, shaded)), 0);
}

TEST(SensorNoise, EdgesJitterByHalfAPixel) {
    DepthLayer step = plane(1.5F, 1);
    for (int v = 0; v < height; ++v)
        for (int u = width / 2; u < width; ++u) step.z[static_cast<size_t>(v) * width + u] = 3;
    const DepthImage image = noisy({}, step);
    size_t moved = 0, far_from_edge = 0;
    for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u) {
            const uint16_t mm = image.at(u, v);
            if (mm == 0 || (mm > 2200) == (u >= width / 2)) continue;
            ++moved;
            if (u < width / 2 - 2 || u >= width / 2 + 2) ++far_from_edge;
        }
    // A shift of N(0, 0.5) crosses the half pixel to the neighbour with probability 0.16 on either side.
    EXPECT_NEAR(static_cast<double>(moved) / height, 0.32, 0.08);
    EXPECT_EQ(far_from_edge, 0U);
}

TEST(SensorNoise, LevelZeroLeavesOnlyTheSteps) {
    const DepthLayer layer = plane(2, 1);
    const DepthImage image = noisy({.level = 0}, layer);
    EXPECT_TRUE(std::all_of(image.millimetres.begin(), image.millimetres.end(), [&](uint16_t mm) {
        return mm == image.millimetres[0] && std::abs(mm - 2000) <= 6;
    }));
}

TEST(SensorNoise, SameSeedAndFrameSameBytes) {
    const DepthLayer layer = plane(2, 0.7F);
    const DepthImage a = noisy({}, layer, 3, 9);
    EXPECT_EQ(a.millimetres, noisy({}, layer, 3, 9).millimetres);
    EXPECT_NE(a.millimetres, noisy({}, layer, 3, 10).millimetres);
    EXPECT_NE(a.millimetres, noisy({}, layer, 4, 9).millimetres);
}

TEST(SensorNoise, ParamsOutOfRangeAreNamed) {
    EXPECT_TRUE(SensorNoiseParams{}.validate().empty());
    const InvalidSettings bad = SensorNoiseParams{.level = -1, .step = 0, .farthest = 0.1}.validate();
    ASSERT_EQ(bad.size(), 3U);
    EXPECT_EQ(bad[0].key, "level");
    EXPECT_EQ(bad[1].key, "step");
    EXPECT_EQ(bad[2].key, "farthest");
}

}  // namespace
}  // namespace deixis
