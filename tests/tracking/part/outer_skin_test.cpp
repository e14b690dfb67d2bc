// The skin of meshes good and bad.
#include "tracking/part/outer_skin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/tracking/part/synthetic_cell.h"

namespace deixis {
namespace {

using namespace synthetic;

TEST(SkinDirections, CoverTheSphereAndAreFoundAgain) {
    std::mt19937 random(2);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3f v =
            Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
        EXPECT_GT(skin_direction(skin_direction_index(v)).dot(v), std::cos(0.24F));
    }
    for (int i = 0; i < skin_directions; ++i) EXPECT_NEAR(skin_direction(i).norm(), 1, 1e-5);
}

TEST(OuterSkin, OfAClosedWallIsItsOutsideWhateverTheWinding) {
    SurfaceMesh mesh = box({0, 0, 0}, {0.4F, 0.3F, 0.2F});
    append(mesh, box({0.003F, 0.003F, 0.003F}, {0.397F, 0.297F, 0.197F}));  // the inside of a 3 mm wall
    append(mesh, box({0.1F, 0.1F, 0.1F}, {0.15F, 0.15F, 0.15F}));           // something shut in
    for (size_t t = 0; t < mesh.triangles.size(); t += 3)
        std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
    mesh.triangles.push_back(mesh.triangles[0]);  // twice the same
    mesh.triangles.push_back({0, 0, 1});          // no area
    const auto skin = sample_outer_skin(mesh, {});
    ASSERT_GT(skin.size(), 3000U);
    const Eigen::Vector3f middle(0.2F, 0.15F, 0.1F), half(0.2F, 0.15F, 0.1F);
    for (const SkinPoint& p : skin) {
        const Eigen::Vector3f off = (p.position - middle).cwiseAbs() - half;
        EXPECT_NEAR(off.maxCoeff(), 0, 1e-5) << "on the outside";
        EXPECT_GT(p.normal.dot(p.position - middle), 0.05F) << "away from the material";
        EXPECT_TRUE(p.outer);
    }
}

TEST(OuterSkin, SpacingIsAsAskedFor) {
    const SurfaceMesh mesh = box({0, 0, 0}, {0.5F, 0.5F, 0.5F});
    for (const double spacing : {0.01, 0.03}) {
        OuterSkinParams params;
        params.spacing = spacing;
        const double expected = 6 * 0.25 / (spacing * spacing);
        EXPECT_NEAR(static_cast<double>(sample_outer_skin(mesh, params).size()), expected, 0.15 * expected);
    }
}

TEST(OuterSkin, AThinShellHasAnOuterAndAnInnerSide) {
    const SurfaceMesh mesh = bumper_shell(false);
    OuterSkinParams params;
    params.spacing = 0.02;
    const auto skin = sample_outer_skin(mesh, params);
    int outer_forward = 0, outer = 0, inner_backward = 0, inner = 0;
    for (const SkinPoint& p : skin) {
        if (std::abs(p.normal.y()) < 0.5F || std::abs(p.position.x()) > 0.6F) continue;
        ++(p.outer ? outer : inner);
        outer_forward += p.outer && p.normal.y() < 0;
        inner_backward += !p.outer && p.normal.y() > 0;
    }
    EXPECT_GT(outer, 1000);
    EXPECT_NEAR(inner, outer, 0.15 * outer);
    EXPECT_GT(outer_forward, 0.90 * outer);
    EXPECT_GT(inner_backward, 0.90 * inner);
}

TEST(OuterSkin, ASheetGivesTwoPointsBackToBack) {
    SurfaceMesh sheet{{{0, 0, 0}, {0.5F, 0, 0}, {0.5F, 0.5F, 0}, {0, 0.5F, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    const auto skin = sample_outer_skin(sheet, {});
    const auto up =
        std::count_if(skin.begin(), skin.end(), [](const SkinPoint& p) { return p.normal.z() > 0; });
    EXPECT_EQ(up * 2, static_cast<long>(skin.size()));
}

TEST(OuterSkin, VisibilityKnowsThePartsOwnShadow) {
    // A floor with a wall on it: a point of the floor near the wall is not seen from behind the wall.
    SurfaceMesh mesh = box({-0.5F, -0.5F, -0.02F}, {0.5F, 0.5F, 0});
    append(mesh, box({-0.5F, 0, 0}, {0.5F, 0.02F, 0.4F}));
    const int from_behind = skin_direction_index(Eigen::Vector3f(0, 1, 0.6F).normalized());
    const int from_front = skin_direction_index(Eigen::Vector3f(0, -1, 0.6F).normalized());
    int checked = 0;
    OuterSkinParams params;
    params.spacing = 0.02;
    for (const SkinPoint& p : sample_outer_skin(mesh, params)) {
        if (p.normal.z() < 0.9F || std::abs(p.position.z()) > 1e-3F) continue;
        if (p.position.y() > -0.1F || p.position.y() < -0.3F || std::abs(p.position.x()) > 0.3F) continue;
        ++checked;
        EXPECT_TRUE(p.visible_from.test(from_front));
        EXPECT_FALSE(p.visible_from.test(from_behind));
    }
    EXPECT_GT(checked, 60);
}

TEST(OuterSkin, NothingComesFromNothing) {
    EXPECT_TRUE(sample_outer_skin({}, {}).empty());
    EXPECT_TRUE(sample_outer_skin({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}}, {}).empty());
    EXPECT_EQ(OuterSkinParams{}.validate().size(), 0U);
    OuterSkinParams bad;
    bad.spacing = 0;
    ASSERT_EQ(bad.validate().size(), 1U);
    EXPECT_EQ(bad.validate()[0].key, "spacing");
}

}  // namespace
}  // namespace deixis
