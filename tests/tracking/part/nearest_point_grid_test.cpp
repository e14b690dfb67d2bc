// The grid against the plain loop over all points.
#include "tracking/part/nearest_point_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace deixis {
namespace {

std::vector<Eigen::Vector3f> random_points(unsigned seed, int count) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> place(-0.3F, 0.3F);
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < count; ++i) points.emplace_back(place(random), 0.3F * place(random), place(random));
    return points;
}

TEST(NearestPointGrid, AtMostOneCellDiagonalFartherThanThePlainLoop) {
    const auto points = random_points(3, 400);
    std::vector<uint32_t> members;
    for (uint32_t i = 0; i < points.size(); i += 2) members.push_back(i);
    constexpr float cell = 0.01F, margin = 0.1F;
    const NearestPointGrid grid(points, members, cell, margin);
    int inside = 0;
    for (const Eigen::Vector3f& q : random_points(4, 3000)) {
        const Eigen::Vector3f p = 1.3F * q;
        float best = std::numeric_limits<float>::max();
        for (const uint32_t m : members) best = std::min(best, (points[m] - p).norm());
        const uint32_t found = grid.find(p);
        if (best > margin + 2 * cell) {
            EXPECT_EQ(found, NearestPointGrid::none);
        } else if (best < margin - 2 * cell) {
            ASSERT_NE(found, NearestPointGrid::none);
            EXPECT_EQ(found % 2, 0U) << "only members are answered";
            EXPECT_LE((points[found] - p).norm(), best + 2 * std::sqrt(3.0F) * cell);
            ++inside;
        }
    }
    EXPECT_GT(inside, 500);
}

TEST(NearestPointGrid, AnswersNothingForNaNAndFarPointsAndWhenEmpty) {
    const auto points = random_points(5, 10);
    std::vector<uint32_t> members(points.size());
    std::iota(members.begin(), members.end(), 0U);
    const NearestPointGrid grid(points, members, 0.01F, 0.05F);
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(),
                    infinity = std::numeric_limits<float>::infinity();
    for (const Eigen::Vector3f& p : {Eigen::Vector3f(nan, 0, 0), Eigen::Vector3f(0, infinity, 0),
                                     Eigen::Vector3f(0, 0, -infinity), Eigen::Vector3f(1e30F, 0, 0)})
        EXPECT_EQ(grid.find(p), NearestPointGrid::none);
    EXPECT_EQ(NearestPointGrid().find(points[0]), NearestPointGrid::none);
    EXPECT_EQ(NearestPointGrid(points, {}, 0.01F, 0.05F).find(points[0]), NearestPointGrid::none);
    EXPECT_TRUE(NearestPointGrid().empty());
    EXPECT_FALSE(grid.empty());
}

TEST(NearestPointGrid, EachPointFindsItselfOrOneInItsCell) {
    const auto points = random_points(6, 300);
    std::vector<uint32_t> members(points.size());
    std::iota(members.begin(), members.end(), 0U);
    const NearestPointGrid grid(points, members, 0.004F, 0.02F);
    for (uint32_t i = 0; i < points.size(); ++i)
        EXPECT_LT((points[grid.find(points[i])] - points[i]).norm(), 0.004F * std::sqrt(3.0F));
}

}  // namespace
}  // namespace deixis
