// Rest and motion from poses alone.
#include "tracking/part/rest_detector.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace deixis {
namespace {

constexpr int64_t frame_us = 33'333;

RigidTransform shifted(double x) {
    return {Eigen::Matrix3d::Identity(), {x, 0, 0}};
}

class RestDetectorTest : public testing::Test {
  protected:
    void feed(const RigidTransform& pose, int frames, bool certain = true) {
        for (int i = 0; i < frames; ++i) rest_.add(now_ += frame_us, pose, certain);
    }
    RestDetector rest_{Eigen::Vector3d::Zero(), 0.9, {}};
    int64_t now_ = 1'000'000;
};

TEST_F(RestDetectorTest, RestsAfterHalfASecondAndNotBefore) {
    feed(shifted(0), 15);
    EXPECT_FALSE(rest_.at_rest());
    feed(shifted(0), 3);
    EXPECT_TRUE(rest_.at_rest());
    EXPECT_FALSE(rest_.leaving());
}

TEST_F(RestDetectorTest, TimeIsThatOfTheStampsNotTheFrames) {
    for (int i = 0; i < 100; ++i) rest_.add(now_ += 1000, shifted(0), true);
    EXPECT_FALSE(rest_.at_rest());
    for (int i = 0; i < 8; ++i) rest_.add(now_ += 100'000, shifted(0), true);
    EXPECT_TRUE(rest_.at_rest());
    RestDetector stuck(Eigen::Vector3d::Zero(), 0.9, {});
    for (int i = 0; i < 100; ++i) stuck.add(5, shifted(0), true);
    EXPECT_FALSE(stuck.at_rest()) << "a clock that stands";
}

TEST_F(RestDetectorTest, SlowPushingIsNotRest) {
    for (int i = 0; i < 200; ++i) feed(shifted(0.001 * i), 1);  // 3 cm/s
    EXPECT_FALSE(rest_.at_rest());
    for (int i = 0; i < 200; ++i)
        feed({Eigen::AngleAxisd(0.001 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
              shifted(0.2).translation},
             1);
    EXPECT_FALSE(rest_.at_rest()) << "turning in place";
}

TEST_F(RestDetectorTest, NoiseIsAveragedAway) {
    std::mt19937 random(4);
    std::normal_distribution<double> noise(0, 0.001);
    for (int i = 0; i < 120; ++i)
        feed({Eigen::Matrix3d::Identity(), {noise(random), noise(random), noise(random)}}, 1);
    ASSERT_TRUE(rest_.at_rest());
    EXPECT_LT(rest_.resting_pose().translation.norm(), 0.0006);
}

TEST_F(RestDetectorTest, MotionEndsItWithinTwoFrames) {
    feed(shifted(0), 30);
    feed(shifted(0.008), 1);
    EXPECT_TRUE(rest_.at_rest());
    EXPECT_TRUE(rest_.leaving());
    feed(shifted(0.012), 1);
    EXPECT_FALSE(rest_.at_rest());
    feed(shifted(0.012), 18);
    EXPECT_TRUE(rest_.at_rest()) << "and it rests again where it is now";
    EXPECT_NEAR(rest_.resting_pose().translation.x(), 0.012, 1e-9);
    feed(shifted(0.5), 1);
    EXPECT_FALSE(rest_.at_rest()) << "a leap ends it at once";
}

TEST_F(RestDetectorTest, UncertainPosesNeitherEndItNorMoveIt) {
    feed(shifted(0), 30);
    feed(shifted(0.010), 1, false);
    EXPECT_FALSE(rest_.leaving());
    feed(shifted(0.010), 20, false);
    EXPECT_TRUE(rest_.at_rest());
    EXPECT_TRUE(rest_.leaving()) << "but the measured pose is shown";
    EXPECT_NEAR(rest_.resting_pose().translation.x(), 0, 1e-9);
    feed(shifted(0.008), 1);
    feed(shifted(0), 1);
    feed(shifted(0.008), 1);
    EXPECT_TRUE(rest_.at_rest()) << "single frames away do not add up";
    rest_.reset();
    EXPECT_FALSE(rest_.at_rest());
}

}  // namespace
}  // namespace deixis
