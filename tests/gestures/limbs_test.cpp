// Limbs of bodies made of voxels: what sticks out is found, with its length; loops and bumps are not limbs.
#include "gestures/limbs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace deixis {
namespace {

constexpr float kSide = 0.03F;

/// Solid boxes of voxels, a head on top.
class VoxelBody {
  public:
    VoxelBody() { lattice_ = VoxelLattice::covering({{-1, -1, 0}, {1, 1, 2}}, kSide); }

    VoxelBody& box(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
        for (float z = low.z(); z < high.z(); z += kSide / 2)
            for (float y = low.y(); y < high.y(); y += kSide / 2)
                for (float x = low.x(); x < high.x(); x += kSide / 2)
                    if (const int64_t v = lattice_.find({x, y, z}); v >= 0)
                        voxels_.insert(static_cast<uint32_t>(v));
        return *this;
    }

    WorkerBody body() const {
        WorkerBody body;
        body.present = true;
        body.lattice = lattice_;
        body.voxels.assign(voxels_.begin(), voxels_.end());
        body.head_top = {0, 0, 1.75F};
        body.height = 1.75F;
        return body;
    }

    static VoxelBody standing() {
        return VoxelBody()
            .box({-0.1F, -0.1F, 1.5F}, {0.1F, 0.1F, 1.75F})
            .box({-0.2F, -0.1F, 0.85F}, {0.2F, 0.1F, 1.5F})
            .box({-0.18F, -0.07F, 0}, {-0.04F, 0.07F, 0.85F})
            .box({0.04F, -0.07F, 0}, {0.18F, 0.07F, 0.85F});
    }

  private:
    VoxelLattice lattice_;
    std::set<uint32_t> voxels_;
};

std::vector<Limb> limbs_of(const WorkerBody& body, LimbFinder::Params params = {}) {
    LimbFinder finder(params);
    return finder.update(body);
}

/// The limb whose tip is within 8 cm of `p`.
const Limb* limb_at(const std::vector<Limb>& limbs, const WorkerBody& body, const Eigen::Vector3f& p) {
    const auto found = std::find_if(limbs.begin(), limbs.end(), [&](const Limb& limb) {
        return (body.lattice.centre(limb.tip) - p).norm() < 0.08F;
    });
    return found == limbs.end() ? nullptr : &*found;
}

TEST(Limbs, BothLegsOfAStandingBodyAndNothingElse) {
    const WorkerBody body = VoxelBody::standing().body();
    const auto limbs = limbs_of(body);
    ASSERT_EQ(limbs.size(), 2U);
    for (const Limb& limb : limbs) EXPECT_LT(body.lattice.centre(limb.tip).z(), 0.1F);
}

TEST(Limbs, AStretchedArmWithItsLength) {
    const WorkerBody body = VoxelBody::standing().box({0.12F, 0.1F, 1.36F}, {0.2F, 0.75F, 1.44F}).body();
    const auto limbs = limbs_of(body);
    const Limb* arm = limb_at(limbs, body, {0.16F, 0.73F, 1.4F});
    ASSERT_NE(arm, nullptr);
    EXPECT_NEAR(arm->length, 0.64F, 0.09F);
    EXPECT_LT((body.lattice.centre(arm->root) - Eigen::Vector3f(0.16F, 0.1F, 1.4F)).norm(), 0.15F);
    ASSERT_EQ(arm->voxels.size(), arm->to_tip.size());
    EXPECT_TRUE(std::is_sorted(arm->to_tip.begin(), arm->to_tip.end()));
    for (const uint32_t v : arm->voxels) EXPECT_GT(body.lattice.centre(v).y(), 0.05F);
}

TEST(Limbs, TwoArmsAreTwo) {
    const WorkerBody body = VoxelBody::standing()
                                .box({0.12F, 0.1F, 1.36F}, {0.2F, 0.75F, 1.44F})
                                .box({-0.2F, 0.1F, 1.3F}, {-0.12F, 0.7F, 1.38F})
                                .body();
    const auto limbs = limbs_of(body);
    EXPECT_NE(limb_at(limbs, body, {0.16F, 0.73F, 1.4F}), nullptr);
    EXPECT_NE(limb_at(limbs, body, {-0.16F, 0.68F, 1.34F}), nullptr);
}

TEST(Limbs, AnArmOfAHalfSeenBodyWithoutLegs) {
    const WorkerBody body = VoxelBody()
                                .box({-0.1F, -0.1F, 1.5F}, {0.1F, 0.1F, 1.75F})
                                .box({-0.2F, -0.1F, 1.0F}, {0.2F, 0.1F, 1.5F})
                                .box({0.12F, 0.1F, 1.36F}, {0.2F, 0.75F, 1.44F})
                                .body();
    const auto limbs = limbs_of(body);
    const Limb* arm = limb_at(limbs, body, {0.16F, 0.73F, 1.4F});
    ASSERT_NE(arm, nullptr);
    EXPECT_NEAR(arm->length, 0.64F, 0.12F);
}

TEST(Limbs, AHandAtTheHipIsALoopAndNoLimb) {
    const WorkerBody body = VoxelBody::standing()
                                .box({0.2F, -0.04F, 1.3F}, {0.45F, 0.04F, 1.4F})
                                .box({0.38F, -0.04F, 1.0F}, {0.46F, 0.04F, 1.4F})
                                .box({0.2F, -0.04F, 0.98F}, {0.46F, 0.04F, 1.06F})
                                .body();
    for (const Limb& limb : limbs_of(body)) EXPECT_LT(body.lattice.centre(limb.tip).z(), 0.1F);
}

TEST(Limbs, AGapIsBridgedUpToItsWidth) {
    const WorkerBody body = VoxelBody::standing()
                                .box({0.12F, 0.1F, 1.36F}, {0.2F, 0.35F, 1.44F})
                                .box({0.12F, 0.47F, 1.36F}, {0.2F, 0.8F, 1.44F})
                                .body();
    EXPECT_NE(limb_at(limbs_of(body), body, {0.16F, 0.78F, 1.4F}), nullptr);
    LimbFinder::Params narrow;
    narrow.bridge_m = 0.05;
    EXPECT_EQ(limb_at(limbs_of(body, narrow), body, {0.16F, 0.78F, 1.4F}), nullptr);
}

TEST(Limbs, BumpsAreNone) {
    const WorkerBody body = VoxelBody::standing().box({-0.1F, 0.1F, 1.2F}, {0.1F, 0.25F, 1.35F}).body();
    EXPECT_EQ(limbs_of(body).size(), 2U);
}

TEST(Limbs, UglyBodies) {
    WorkerBody nobody;
    EXPECT_TRUE(limbs_of(nobody).empty());
    WorkerBody one = VoxelBody::standing().body();
    one.voxels.resize(1);
    EXPECT_TRUE(limbs_of(one).empty());
    WorkerBody headless = VoxelBody().box({-0.2F, -0.1F, 0.2F}, {0.2F, 0.1F, 0.6F}).body();
    EXPECT_TRUE(limbs_of(headless).empty());
    WorkerBody broken = VoxelBody::standing().body();
    broken.head_top = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    EXPECT_TRUE(limbs_of(broken).empty());
}

TEST(Limbs, AFinderThatIsUsedAgainGivesTheSame) {
    const WorkerBody a = VoxelBody::standing().box({0.12F, 0.1F, 1.36F}, {0.2F, 0.75F, 1.44F}).body();
    const WorkerBody b = VoxelBody::standing().body();
    LimbFinder finder({});
    const auto first = finder.update(a);
    EXPECT_EQ(finder.update(b).size(), 2U);
    const auto again = finder.update(a);
    ASSERT_EQ(first.size(), again.size());
    for (size_t k = 0; k < first.size(); ++k) EXPECT_EQ(first[k].voxels, again[k].voxels);
}

TEST(Limbs, ParamsNameWhatIsOutOfRange) {
    EXPECT_TRUE(LimbFinder::Params{}.validate().empty());
    LimbFinder::Params params;
    params.min_length_m = 0;
    params.bridge_m = 2;
    EXPECT_EQ(params.validate().size(), 2U);
}

}  // namespace
}  // namespace deixis
