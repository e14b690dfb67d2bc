// The tracker on rendered framesets of small images: states, loss, return, rest, determinism.
#include "tracking/part/part_tracker.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/tracking/part/bumper_model.h"
#include "tests/tracking/part/synthetic_cell.h"

namespace deixis {
namespace {

using namespace synthetic;

RigidTransform pose_at(double x, double y, double yaw) {
    return {Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {x, y, 0.7}};
}

class PartTrackerTest : public BumperModelTest {
  protected:
    void SetUp() override { tracker_.emplace(*model_, sensors_, PartTrackerParams{}); }

    const PartEstimate& see(const std::vector<SurfaceMesh>& scene) {
        frameset_ = render(sensors_, scene, stamp_ += 33'333, seed_++);
        return tracker_->update(frameset_, surface_points(sensors_, frameset_, empty_));
    }
    PartEstimate see_part(const RigidTransform& pose, int frames) {
        for (int i = 0; i < frames; ++i) see({moved(*mesh_, pose)});
        return tracker_->estimate();
    }
    static void expect_near(const PartEstimate& estimate, const RigidTransform& truth) {
        ASSERT_EQ(estimate.state, PartState::tracking) << estimate.reason;
        EXPECT_LT(error_between(estimate.world_from_part, truth).mm, 10);
        EXPECT_LT(error_between(estimate.world_from_part, truth).degree, 1);
    }

    std::vector<CalibratedSensor> sensors_ = two_kinects(4, 2);
    Frameset empty_ = render(sensors_, {}, 0, 999), frameset_;
    std::optional<PartTracker> tracker_;
    int64_t stamp_ = 0;
    unsigned seed_ = 1;
};

TEST_F(PartTrackerTest, AnEmptyCellHoldsNoPart) {
    EXPECT_EQ(tracker_->estimate().state, PartState::searching);
    EXPECT_EQ(see({}).state, PartState::absent);
    EXPECT_FALSE(tracker_->estimate().reason.empty());
    EXPECT_EQ(tracker_->update({}, {}).state, PartState::absent) << "not even sensors";
}

TEST_F(PartTrackerTest, FindsRestsMovesAndLoses) {
    const RigidTransform start = pose_at(-0.2, 0.1, 0.2);
    EXPECT_EQ(see_part(start, 1).state, PartState::searching);
    expect_near(see_part(start, 3), start);
    EXPECT_FALSE(tracker_->estimate().at_rest);
    expect_near(see_part(start, 16), start);
    EXPECT_TRUE(tracker_->estimate().at_rest);
    EXPECT_GT(tracker_->estimate().fitness, 0.9);

    for (int i = 1; i <= 12; ++i) {
        const double s = i / 12.0;
        const RigidTransform now = pose_at(-0.2 + 0.24 * s, 0.1, 0.2 - 0.15 * s);
        expect_near(see_part(now, 1), now);
        if (i > 2) {
            EXPECT_FALSE(tracker_->estimate().at_rest) << i;
        }
    }
    for (int i = 0; i < 3; ++i) see({});
    EXPECT_EQ(tracker_->estimate().state, PartState::lost);
    EXPECT_FALSE(tracker_->estimate().at_rest);
    see({});
    EXPECT_EQ(tracker_->estimate().state, PartState::absent);

    const RigidTransform again = pose_at(0.3, 0.2, -0.3);
    expect_near(see_part(again, 14), again);
}

TEST_F(PartTrackerTest, OneEyeIsEnough) {
    const RigidTransform pose = pose_at(0, 0.1, 0.1);
    see_part(pose, 4);
    for (int i = 0; i < 3; ++i) {
        Frameset half = render(sensors_, {moved(*mesh_, pose)}, stamp_ += 33'333, seed_++);
        half.frames[1].present = false;
        expect_near(tracker_->update(half, surface_points(sensors_, half, empty_)), pose);
    }
}

TEST_F(PartTrackerTest, AnotherThingIsNotThePart) {
    const SurfaceMesh cupboard = box({-0.8F, 0.2F, 0}, {0.6F, 0.6F, 1.1F});
    for (int i = 0; i < 11; ++i) {
        see({cupboard, person({0.2F, -0.6F}, {0.4F, 0, 1.1F})});
        EXPECT_NE(tracker_->estimate().state, PartState::tracking);
        EXPECT_NE(tracker_->estimate().state, PartState::searching);
    }
}

TEST_F(PartTrackerTest, APlainShellIsNotLocked) {
    std::vector<Eigen::Vector2f> profile;
    for (int i = 0; i <= 20; ++i) {
        const float t = static_cast<float>(i) / 20;
        profile.emplace_back(0.12F * t * t - 0.05F * std::sin(3 * t), 0.4F * t);
    }
    const SurfaceMesh shell = extruded_shell(profile, 1.7F, 2.5F);
    const auto model = ReferenceModel::build(shell, {});
    ASSERT_TRUE(model);
    tracker_.emplace(*model, sensors_, PartTrackerParams{});
    int ambiguous = 0;
    for (int i = 0; i < 11; ++i) {
        const PartEstimate& e = see({moved(shell, pose_at(0, 0.1, 0))});
        EXPECT_NE(e.state, PartState::tracking);
        ambiguous += e.state == PartState::ambiguous;
    }
    EXPECT_GT(ambiguous, 0);
    EXPECT_FALSE(tracker_->estimate().reason.empty());
}

TEST_F(PartTrackerTest, TheSameFramesGiveTheSameEstimates) {
    std::vector<Frameset> framesets;
    for (int i = 0; i < 6; ++i) {
        const RigidTransform pose = pose_at(0.004 * i, 0.1, 0.1);
        framesets.push_back(render(sensors_, {moved(*mesh_, pose)}, 33'333 * i, 50 + i));
    }
    std::vector<RigidTransform> first;
    for (int run = 0; run < 2; ++run) {
        PartTracker tracker(*model_, sensors_, {});
        for (size_t i = 0; i < framesets.size(); ++i) {
            const PartEstimate& e =
                tracker.update(framesets[i], surface_points(sensors_, framesets[i], empty_));
            if (run == 0) {
                first.push_back(e.world_from_part);
                continue;
            }
            EXPECT_EQ(e.world_from_part.rotation, first[i].rotation);
            EXPECT_EQ(e.world_from_part.translation, first[i].translation);
        }
        EXPECT_EQ(tracker.estimate().state, PartState::tracking);
    }
}

TEST(PartTrackerParams, NamesEverySettingOutOfRange) {
    EXPECT_TRUE(PartTrackerParams{}.validate().empty());
    PartTrackerParams params;
    params.search_period = 0;
    params.max_tilt_deg = 400;
    params.held_fitness = std::nan("");
    params.motion_mm = 1;
    std::vector<std::string> keys;
    for (const InvalidSetting& s : params.validate()) keys.push_back(s.key);
    EXPECT_EQ(keys, (std::vector<std::string>{"search_period", "max_tilt_deg", "held_fitness", "motion_mm"}));
    EXPECT_STREQ(name_of(PartState::ambiguous), "ambiguous");
    EXPECT_STREQ(name_of(PartState::lost), "lost");
}

}  // namespace
}  // namespace deixis
