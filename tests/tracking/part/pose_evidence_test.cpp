// Evidence of rendered depth images for right and wrong poses.
#include "tracking/part/pose_evidence.h"

#include <gtest/gtest.h>

#include "tests/tracking/part/bumper_model.h"
#include "tests/tracking/part/synthetic_cell.h"
#include "tracking/part/reference_model.h"

namespace deixis {
namespace {

using namespace synthetic;

class PoseEvidenceTest : public BumperModelTest {
  protected:
    PoseEvidence evidence(const RigidTransform& pose, const std::vector<SurfaceMesh>& others = {}) {
        std::vector<SurfaceMesh> scene = others;
        scene.push_back(moved(*mesh_, truth_));
        frameset_ = render(sensors_, scene, 0, 5);
        return DepthWitness(sensors_, frameset_).ask(pose, (*model_)->coarse(), 0, 1, 0);
    }

    RigidTransform truth_{Eigen::Matrix3d::Identity(), {0, 0.1, 0.7}};
    std::vector<CalibratedSensor> sensors_ = two_kinects(3, 2);
    Frameset frameset_;
};

TEST_F(PoseEvidenceTest, TheTrueOneIsFound) {
    const PoseEvidence e = evidence(truth_);
    EXPECT_GT(e.facing, 1000);
    EXPECT_GT(e.fitness(), 0.97);
    EXPECT_GT(e.found_share(), 0.85);
    EXPECT_LT(e.residual, 0.25);
    EXPECT_LT(e.seen_through_share(), 0.01);
}

TEST_F(PoseEvidenceTest, OneTooNearIsSeenThrough) {
    RigidTransform wrong = truth_;
    wrong.translation.y() -= 0.3;
    const PoseEvidence e = evidence(wrong);
    EXPECT_GT(e.seen_through_share(), 0.7);
    EXPECT_LT(e.fitness(), 0.1);
}

TEST_F(PoseEvidenceTest, OneBehindIsHiddenNotWrong) {
    RigidTransform wrong = truth_;
    wrong.translation.y() += 0.4;
    const PoseEvidence e = evidence(wrong);
    EXPECT_GT(e.hidden, e.facing / 3);
    EXPECT_LT(e.found_share(), 0.2);
}

TEST_F(PoseEvidenceTest, ASlideShowsAtTheEnd) {
    RigidTransform wrong = truth_;
    wrong.translation.x() += 0.15;
    const PoseEvidence good = evidence(truth_), e = evidence(wrong);
    EXPECT_GT(e.residual, good.residual + 0.1);
    EXPECT_GT(e.seen_through_share(), 0.03);
}

TEST_F(PoseEvidenceTest, SomebodyInFrontHides) {
    const PoseEvidence e = evidence(truth_, {person({-0.3F, -0.8F}, {0.1F, -0.2F, 1.0F})});
    EXPECT_GT(e.hidden, 50);
    EXPECT_GT(e.fitness(), 0.95);
}

TEST_F(PoseEvidenceTest, WithoutImagesThereIsNone) {
    frameset_ = render(sensors_, {}, 0, 5);
    for (DepthFrame& f : frameset_.frames) f.present = false;
    EXPECT_EQ(DepthWitness(sensors_, frameset_).ask(truth_, (*model_)->coarse(), 0, 1, 0).facing, 0);
    for (DepthFrame& f : frameset_.frames) f.present = true, f.depth.resize(10, 10);
    EXPECT_EQ(DepthWitness(sensors_, frameset_).ask(truth_, (*model_)->coarse(), 0, 1, 0).facing, 0)
        << "another size";
    frameset_.frames.clear();
    EXPECT_EQ(DepthWitness(sensors_, frameset_).ask(truth_, (*model_)->coarse(), 0, 1, 0).fitness(), 0);
}

}  // namespace
}  // namespace deixis
