// FPFH: laws of the histograms, and the nearest-neighbour search against the plain loop.
#include "tracking/part/descriptors.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace deixis {
namespace {

struct Cloud {
    std::vector<Eigen::Vector3f> positions, normals;
};

/// A wavy sheet with its true normals.
Cloud wavy_sheet() {
    Cloud cloud;
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 20; ++j) {
            const float x = 0.03F * static_cast<float>(i), y = 0.03F * static_cast<float>(j);
            cloud.positions.emplace_back(x, y, 0.05F * std::sin(9 * x) * std::cos(5 * y));
            cloud.normals.push_back(Eigen::Vector3f(-0.45F * std::cos(9 * x) * std::cos(5 * y),
                                                    0.25F * std::sin(9 * x) * std::sin(5 * y), 1)
                                        .normalized());
        }
    return cloud;
}

TEST(Descriptors, EachHistogramSumsToAHundred) {
    const Cloud cloud = wavy_sheet();
    for (const Descriptor& d : describe(cloud.positions, cloud.normals, 0.1))
        for (int h = 0; h < 3; ++h)
            EXPECT_NEAR(std::accumulate(d.begin() + 11 * h, d.begin() + 11 * h + 11, 0.0F), 100, 0.1);
}

TEST(Descriptors, DoNotChangeUnderARigidMotion) {
    const Cloud cloud = wavy_sheet();
    const Eigen::Matrix3f rotation =
        Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, 2, -1).normalized()).toRotationMatrix();
    Cloud turned;
    for (size_t i = 0; i < cloud.positions.size(); ++i) {
        turned.positions.emplace_back(rotation * cloud.positions[i] + Eigen::Vector3f(0.3F, -0.2F, 0.9F));
        turned.normals.emplace_back(rotation * cloud.normals[i]);
    }
    const auto before = describe(cloud.positions, cloud.normals, 0.1);
    const auto after = describe(turned.positions, turned.normals, 0.1);
    double difference = 0;
    for (size_t i = 0; i < before.size(); ++i)
        for (size_t k = 0; k < 33; ++k)
            difference += std::abs(static_cast<double>(before[i][k] - after[i][k]));
    EXPECT_LT(difference / static_cast<double>(before.size()), 8)
        << "of 300, from values at the borders of bins";
}

TEST(Descriptors, AreZeroWithoutNormalOrPosition) {
    Cloud cloud = wavy_sheet();
    cloud.normals[5].setZero();
    cloud.positions[9].x() = std::numeric_limits<float>::quiet_NaN();
    const auto d = describe(cloud.positions, cloud.normals, 0.1);
    EXPECT_EQ(d[5], Descriptor{});
    EXPECT_EQ(d[9], Descriptor{});
    EXPECT_NE(d[6], Descriptor{});
    EXPECT_TRUE(describe({}, {}, 0.1).empty());
}

TEST(Descriptors, NearestAgreeWithThePlainLoop) {
    std::mt19937 random(1);
    std::uniform_int_distribution<int> value(0, 3);
    std::vector<Descriptor> base(80), queries(40);
    for (auto* set : {&base, &queries})
        for (Descriptor& d : *set)
            for (float& x : d) x = static_cast<float>(value(random));
    base[7] = base[3];
    queries[0] = base[3];
    queries[1] = Descriptor{};
    constexpr int count = 5;
    const auto nearest = nearest_descriptors(queries, base, count);
    for (size_t q = 0; q < queries.size(); ++q) {
        if (q == 1) {
            EXPECT_EQ(nearest[q * count], -1);
            continue;
        }
        std::vector<std::pair<float, int32_t>> all;
        for (size_t b = 0; b < base.size(); ++b) {
            float sum = 0;
            for (size_t k = 0; k < 33; ++k)
                sum += (base[b][k] - queries[q][k]) * (base[b][k] - queries[q][k]);
            all.emplace_back(sum, static_cast<int32_t>(b));
        }
        std::sort(all.begin(), all.end());
        for (size_t k = 0; k < count; ++k) EXPECT_EQ(nearest[q * count + k], all[k].second);
    }
    EXPECT_EQ(nearest[0], 3) << "of equals the first";
    EXPECT_EQ(nearest[1], 7);
}

TEST(Descriptors, FewerThanAskedForAreFilledUp) {
    std::vector<Descriptor> one(1);
    one[0].fill(1);
    EXPECT_EQ(nearest_descriptors(one, one, 3), (std::vector<int32_t>{0, 0, 0}));
    EXPECT_EQ(nearest_descriptors(one, {}, 2), (std::vector<int32_t>{-1, -1}));
}

}  // namespace
}  // namespace deixis
