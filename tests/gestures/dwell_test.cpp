// Holds, short holds, slow ends, gaps and motion of the part: what becomes a mark, how often, and what does
// not.
#include "gestures/dwell.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace deixis {
namespace {

using Eigen::Vector3d;

const Vector3d held(0.1, 0.5, 1.0), hanging(0.2, -0.2, 0.75), other(0.5, 0.5, 1.0);

/// 0 to 1 with the least jerk.
double minimum_jerk(double s) {
    s = std::clamp(s, 0.0, 1.0);
    return s * s * s * (10 - 15 * s + 6 * s * s);
}

/// A fingertip over time: rests, reaches out, holds, draws back, as often as wanted.
struct Motion {
    struct Key {
        double t0, t1;
        Vector3d to;
    };
    std::vector<Key> keys;
    double now = 0;

    Motion& go(const Vector3d& to, double seconds) {
        keys.push_back({now, now + seconds, to});
        now += seconds;
        return *this;
    }
    Motion& hold(double seconds) {
        now += seconds;
        return *this;
    }
    Vector3d at(double t) const {
        Vector3d p = hanging;
        for (const Key& key : keys)
            if (t > key.t0) p += minimum_jerk((t - key.t0) / (key.t1 - key.t0)) * (key.to - p);
        return p;
    }
};

/// The spot straight ahead of the tip, on the plane y = 0.6.
PointingRay ray_from(const Vector3d& tip) {
    PointingRay ray;
    ray.arm = ArmSide::left;
    ray.origin = tip;
    ray.direction = Vector3d::UnitY();
    if (tip.y() > 0.1) ray.hit = PartSpot{{tip.x(), 0.6, tip.z()}, -Vector3d::UnitY()};
    return ray;
}

struct Play {
    double fps = 30;
    double noise = 0.006;  ///< of the tip, each axis [m]
    unsigned seed = 1;
    DwellDetector::Params params;
    std::function<bool(double)> present = [](double) { return true; };
    std::function<bool(double)> at_rest = [](double) { return true; };
    int64_t start_us = 5'000'000;

    std::vector<Mark> run(const Motion& motion) const {
        DwellDetector detector(params);
        std::mt19937 random(seed);
        std::normal_distribution<double> normal(0, noise);
        std::vector<Mark> marks;
        for (int k = 0; k / fps < motion.now; ++k) {
            const double t = k / fps;
            Vector3d tip = motion.at(t);
            for (int axis = 0; axis < 3; ++axis) tip[axis] += normal(random);
            const auto ray = present(t) ? std::optional(ray_from(tip)) : std::nullopt;
            if (auto mark = detector.update(start_us + std::llround(1e6 * t), ray, at_rest(t)))
                marks.push_back(*mark);
        }
        return marks;
    }
};

Motion point_once(double hold_s, double reach_s = 0.8) {
    return Motion().hold(0.5).go(held, reach_s).hold(hold_s).go(hanging, 0.7).hold(0.8);
}

TEST(Dwell, AHeldPointIsOneMarkAtItsPlace) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Play play;
        play.seed = seed;
        const auto marks = play.run(point_once(1.4));
        ASSERT_EQ(marks.size(), 1U) << seed;
        EXPECT_LT((marks[0].spot.position - Vector3d(0.1, 0.6, 1.0)).norm(), 0.008);
        EXPECT_EQ(marks[0].arm, ArmSide::left);
        EXPECT_FALSE(marks[0].touch);
        EXPECT_GT(marks[0].confidence, 0.7);
        EXPECT_LE(marks[0].confidence, 1.0);
        const double at = static_cast<double>(marks[0].timestamp_us - play.start_us) * 1e-6;
        EXPECT_GT(at, 2.0);
        EXPECT_LT(at, 2.6);
    }
}

TEST(Dwell, HoldingOnForLongIsStillOneMark) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
        Play play;
        play.seed = seed;
        EXPECT_EQ(play.run(point_once(8.0)).size(), 1U);
    }
}

TEST(Dwell, TooShortAHoldIsNone) {
    for (unsigned seed = 1; seed <= 20; ++seed)
        for (const double hold : {0.0, 0.4, 0.55, 0.7})
            for (const double reach : {0.5, 0.8, 1.1}) {
                Play play;
                play.seed = seed;
                EXPECT_TRUE(play.run(point_once(hold, reach)).empty()) << hold << " after " << reach;
            }
}

TEST(Dwell, AnArmThatPassesIsNone) {
    for (const double speed_s : {1.0, 1.5, 2.5}) {
        const Motion pass = Motion()
                                .hold(0.3)
                                .go(held - Vector3d(0.3, 0, 0), 0.7)
                                .go(held + Vector3d(0.3, 0, 0), speed_s)
                                .go(hanging, 0.7);
        EXPECT_TRUE(Play().run(pass).empty());
    }
}

TEST(Dwell, TwoPlacesAreTwoMarksWithAndWithoutRelaxing) {
    const Motion relaxed =
        Motion().go(held, 0.8).hold(1.5).go(hanging, 0.6).hold(0.4).go(other, 0.8).hold(1.5);
    EXPECT_EQ(Play().run(relaxed).size(), 2U);
    const Motion moved = Motion().go(held, 0.8).hold(1.5).go(other, 0.6).hold(1.5);
    EXPECT_EQ(Play().run(moved).size(), 2U);
}

TEST(Dwell, TheSamePlaceAgainAfterRelaxingIsAnotherMark) {
    const Motion again = Motion().go(held, 0.8).hold(1.5).go(hanging, 0.6).hold(0.5).go(held, 0.8).hold(1.5);
    EXPECT_EQ(Play().run(again).size(), 2U);
}

TEST(Dwell, AFewMissingFramesDoNotMatter) {
    Play play;
    play.present = [](double t) { return std::fmod(t, 0.5) > 0.15; };
    EXPECT_EQ(play.run(point_once(1.6)).size(), 1U);
    play.present = [](double t) { return t < 1.9 || t > 2.3; };  // a gap longer than allowed begins anew
    EXPECT_TRUE(play.run(point_once(1.6)).empty());
    EXPECT_EQ(play.run(point_once(2.4)).size(), 1U);
}

TEST(Dwell, LosingTheArmForAMomentAfterTheMarkGivesNoSecondOne) {
    Play play;
    play.present = [](double t) { return t < 2.8 || t > 3.2; };
    EXPECT_EQ(play.run(point_once(5)).size(), 1U);
}

TEST(Dwell, AMovingOrLostPartBeginsAnew) {
    Play play;
    play.at_rest = [](double) { return false; };
    EXPECT_TRUE(play.run(point_once(3)).empty());
    play.at_rest = [](double t) { return std::abs(t - 2.0) > 0.05; };
    EXPECT_TRUE(play.run(point_once(1.6)).empty());
    EXPECT_EQ(play.run(point_once(2.5)).size(), 1U);
}

TEST(Dwell, AnyFrameRateWillDo) {
    for (const double fps : {12.0, 15.0, 24.0, 60.0}) {
        Play play;
        play.fps = fps;
        EXPECT_EQ(play.run(point_once(1.5)).size(), 1U) << fps;
        EXPECT_TRUE(play.run(point_once(0.7)).empty()) << fps;
    }
}

TEST(Dwell, ADwellTimeOfItsOwn) {
    Play play;
    play.params.dwell_s = 0.6;
    EXPECT_EQ(play.run(point_once(1.0)).size(), 1U);
    play.params.dwell_s = 2.0;
    EXPECT_TRUE(play.run(point_once(1.5)).empty());
    EXPECT_EQ(play.run(point_once(2.6)).size(), 1U);
}

TEST(Dwell, StampsThatJumpBackBeginAnew) {
    DwellDetector detector({});
    const auto ray = ray_from(held);
    int marks = 0;
    for (int k = 0; k < 25; ++k) marks += detector.update(1'000'000 + 33'333 * k, ray, true).has_value();
    for (int k = 0; k < 25; ++k) marks += detector.update(33'333 * k, ray, true).has_value();
    EXPECT_EQ(marks, 0);
    for (int k = 25; k < 60; ++k) marks += detector.update(33'333 * k, ray, true).has_value();
    EXPECT_EQ(marks, 1);
    for (int k = 0; k < 60; ++k) marks += detector.update(33'333 * k, ray, true).has_value();
    EXPECT_EQ(marks, 2);  // another session
}

TEST(Dwell, RaysBesideThePartAndNaNsAreMissingFrames) {
    DwellDetector detector({});
    PointingRay miss = ray_from(held);
    miss.hit.reset();
    PointingRay broken = ray_from(held);
    broken.origin.x() = std::numeric_limits<double>::quiet_NaN();
    PointingRay bad_spot = ray_from(held);
    bad_spot.hit->position.z() = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 90; ++k) {
        EXPECT_FALSE(detector.update(33'333 * (3 * k), miss, true));
        EXPECT_FALSE(detector.update(33'333 * (3 * k + 1), broken, true));
        EXPECT_FALSE(detector.update(33'333 * (3 * k + 2), bad_spot, true));
    }
}

TEST(Dwell, ParamsNameWhatIsOutOfRange) {
    EXPECT_TRUE(DwellDetector::Params{}.validate().empty());
    DwellDetector::Params params;
    params.dwell_s = 0;
    params.gap_s = -1;
    params.steady_share = std::nan("");
    EXPECT_EQ(params.validate().size(), 3U);
}

}  // namespace
}  // namespace deixis
