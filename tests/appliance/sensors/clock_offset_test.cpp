// The minimum-delay filter on simulated clocks with drift, delay and jumps.
#include "appliance/sensors/clock_offset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace deixis {
namespace {

struct SimulatedClock {
    int64_t start_us;  ///< host time at which the sensor's clock shows 0
    double drift;      ///< host seconds per sensor second minus 1
    int64_t least_delay_us = 3'000;
};

/// Largest error after the first second of the mapped stamp against the true host time plus the least delay.
int64_t worst_error(const SimulatedClock& clock, int64_t seconds, std::mt19937& random) {
    std::exponential_distribution<double> delay(1.0 / 4'000);
    ClockOffset offset;
    int64_t worst = 0;
    for (int64_t t = 0; t < seconds * 1'000'000; t += 33'333) {
        const int64_t taken = clock.start_us + t + std::llround(static_cast<double>(t) * clock.drift);
        const int64_t arrived = taken + clock.least_delay_us + std::llround(delay(random));
        const int64_t mapped = t + offset.update(t, arrived);
        EXPECT_LE(mapped, arrived) << "a frame was mapped to a time after its arrival";
        if (t > 1'000'000) worst = std::max(worst, std::abs(mapped - taken - clock.least_delay_us));
    }
    return worst;
}

TEST(ClockOffset, FindsTheOffsetThroughRandomDelays) {
    std::mt19937 random(1);
    EXPECT_LE(worst_error({50'000'000, 0.0}, 60, random), 1'000);
    EXPECT_LE(worst_error({-70'000'000'000, 0.0}, 60, random), 1'000);
}

TEST(ClockOffset, FollowsADriftingClock) {
    std::mt19937 random(2);
    for (const double drift : {100e-6, -100e-6})
        EXPECT_LE(worst_error({10'000'000, drift}, 120, random), 2'000);
}

TEST(ClockOffset, BeginsAfreshWhenTheDeviceDoes) {
    ClockOffset offset;
    for (int64_t t = 0; t < 2'000'000; t += 33'333) offset.update(t, 90'000'000 + t);
    EXPECT_EQ(offset.offset_us(), 90'000'000);
    EXPECT_EQ(offset.update(0, 92'000'000), 92'000'000);
    EXPECT_EQ(offset.update(33'333, 92'040'000), 92'000'000);
}

}  // namespace
}  // namespace deixis
