// Tracks of the floor and of numbers, and the random numbers by counter.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "appliance/simulation/counter_random.h"
#include "appliance/simulation/floor_track.h"

namespace deixis {
namespace {

TEST(Tracks, MinimumJerkStartsAndEndsAtRest) {
    EXPECT_EQ(minimum_jerk(-1), 0);
    EXPECT_EQ(minimum_jerk(2), 1);
    EXPECT_NEAR(minimum_jerk(0.5), 0.5, 1e-12);
    EXPECT_LT(minimum_jerk(0.01), 1.1e-5);
}

TEST(Tracks, ComposeAndRelativeAreInverse) {
    const FloorPose outer{{0.4, -1.2}, 2.8}, pose{{-0.3, 0.9}, -2.2};
    const FloorPose back = relative_to(outer, compose(outer, pose));
    EXPECT_LT((back.position - pose.position).norm(), 1e-12);
    EXPECT_NEAR(wrapped_angle(back.turn - pose.turn), 0, 1e-12);
    EXPECT_NEAR(wrapped_angle(3 * std::numbers::pi), std::numbers::pi, 1e-12);
    EXPECT_NEAR(wrapped_angle(-std::numbers::pi - 0.1), std::numbers::pi - 0.1, 1e-12);
}

TEST(Tracks, RidingKeepsThePlaceOnTheCarrier) {
    FloorTrack trolley(FloorPose{{0, 1}, 0});
    trolley.move(1, 4, {{0.5, 1.2}, 0.4});
    FloorTrack feet(FloorPose{{-0.7, 0.4}, 0.1});
    feet.ride(1, 4, trolley);
    const FloorPose at_start = relative_to(trolley.at(0).pose, feet.at(0).pose);
    for (double t = 0; t < 5; t += 0.1) {
        const FloorPose now = relative_to(trolley.at(t).pose, feet.at(t).pose);
        EXPECT_LT((now.position - at_start.position).norm(), 1e-12);
        EXPECT_NEAR(now.turn, at_start.turn, 1e-12);
    }
    EXPECT_TRUE(trolley.moving(2));
    EXPECT_FALSE(trolley.moving(4.5));
}

TEST(Tracks, VelocityAndDistanceFitThePositions) {
    FloorTrack feet(FloorPose{});
    feet.move(0, 2, {{1.5, 0}, 0});
    feet.move(3, 4, {{1.5, 0.5}, 1});
    for (double t = 0.05; t < 4.5; t += 0.07) {
        const Eigen::Vector2d slope =
            (feet.at(t + 1e-5).pose.position - feet.at(t - 1e-5).pose.position) / 2e-5;
        EXPECT_LT((slope - feet.at(t).velocity).norm(), 1e-4) << t;
    }
    EXPECT_NEAR(feet.at(10).distance, 2.0, 1e-12);
}

TEST(CounterRandom, IsAFunctionOfItsCounterWithTheRightMoments) {
    const CounterRandom random(7, 1), same(7, 1), other(8, 1);
    double sum = 0, squares = 0, uniform = 0;
    std::set<uint64_t> seen;
    constexpr int count = 100'000;
    for (uint64_t i = 0; i < count; ++i) {
        ASSERT_EQ(random.bits(i), same.bits(i));
        seen.insert(random.bits(i));
        seen.insert(other.bits(i));
        const double n = random.normal(i);
        sum += n;
        squares += n * n;
        uniform += random.uniform(i);
    }
    EXPECT_EQ(seen.size(), 2U * count);
    EXPECT_NEAR(sum / count, 0, 0.01);
    EXPECT_NEAR(squares / count, 1, 0.01);
    EXPECT_NEAR(uniform / count, 0.5, 0.005);
}

}  // namespace
}  // namespace deixis
