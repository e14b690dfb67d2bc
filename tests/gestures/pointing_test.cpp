// The regression of eq. 5.3 and the cut of the ray with a surface, against closed forms.
#include "gestures/pointing.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace deixis {
namespace {

using Eigen::Vector3d;

/// Two triangles that span [-w, w] x [-h, h] in x and z at y = 0, facing -y.
SurfaceMesh panel(float w, float h) {
    return {{{-w, 0, -h}, {w, 0, -h}, {w, 0, h}, {-w, 0, h}}, {{0, 1, 2}, {0, 2, 3}}};
}

RayCaster caster_of(const SurfaceMesh& mesh) {
    RayCaster caster;
    caster.add(mesh);
    caster.commit();
    return caster;
}

TEST(FitAlong, IsThesisEquation53AlongY) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::vector<Vector3d> points;
    for (int i = 0; i < 200; ++i) {
        const double y = 0.2 * normal(random);
        points.emplace_back(0.3 + 0.4 * y + 0.01 * normal(random), y, 1.1 - 0.7 * y + 0.01 * normal(random));
    }
    const std::vector<double> weights(points.size(), 1.0);
    const auto line = fit_along(points, weights, Vector3d::UnitY());
    ASSERT_TRUE(line);
    // Ordinary least squares of x on y and of z on y.
    double sy = 0, sx = 0, sz = 0, syy = 0, sxy = 0, szy = 0;
    for (const Vector3d& p : points)
        sy += p.y(), sx += p.x(), sz += p.z(), syy += p.y() * p.y(), sxy += p.x() * p.y(),
            szy += p.z() * p.y();
    const auto n = static_cast<double>(points.size());
    const double a1 = (n * sxy - sx * sy) / (n * syy - sy * sy),
                 a2 = (n * szy - sz * sy) / (n * syy - sy * sy);
    const Vector3d expected = Vector3d(a1, 1, a2).normalized();
    EXPECT_LT((line->direction - expected).norm(), 1e-9);
    const double b1 = (sx - a1 * sy) / n, b2 = (sz - a2 * sy) / n;
    EXPECT_NEAR(line->point.x(), b1 + a1 * line->point.y(), 1e-9);
    EXPECT_NEAR(line->point.z(), b2 + a2 * line->point.y(), 1e-9);
}

TEST(FitAlong, TurnsWithItsAxisAndForgetsTheOrder) {
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    std::vector<Vector3d> points;
    std::vector<double> weights;
    for (int i = 0; i < 60; ++i) {
        const double y = 0.2 * normal(random);
        points.emplace_back(0.4 * y + 0.02 * normal(random), y, 1.1 - 0.7 * y + 0.02 * normal(random));
        weights.push_back(std::abs(normal(random)));
    }
    const auto line = fit_along(points, weights, Vector3d::UnitY());
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    std::vector<Vector3d> turned;
    for (const Vector3d& p : points) turned.push_back(turn * p);
    const auto turned_line = fit_along(turned, weights, turn * Vector3d::UnitY());
    ASSERT_TRUE(line && turned_line);
    EXPECT_LT((turned_line->direction - turn * line->direction).norm(), 1e-9);
    std::reverse(points.begin(), points.end());
    std::reverse(weights.begin(), weights.end());
    EXPECT_LT((fit_along(points, weights, Vector3d::UnitY())->direction - line->direction).norm(), 1e-12);
}

TEST(FitAlong, WeightsOfZeroAreNotThere) {
    const std::vector<Vector3d> points = {{0, 0, 0}, {0, 1, 0}, {5, 0.5, 5}};
    const auto line = fit_along(points, std::vector<double>{1, 1, 0}, Vector3d::UnitY());
    ASSERT_TRUE(line);
    EXPECT_LT((line->direction - Vector3d::UnitY()).norm(), 1e-12);
}

TEST(FitAlong, SaysNothingWithoutADirection) {
    const Vector3d axis = Vector3d::UnitY();
    EXPECT_FALSE(fit_along({}, {}, axis));
    EXPECT_FALSE(fit_along(std::vector<Vector3d>{{1, 2, 3}}, std::vector<double>{1}, axis));
    EXPECT_FALSE(fit_along(std::vector<Vector3d>{{0, 1, 0}, {1, 1, 0}}, std::vector<double>{1, 1}, axis));
    EXPECT_FALSE(fit_along(std::vector<Vector3d>{{0, 1, 0}, {1, 2, 0}}, std::vector<double>{1}, axis));
    EXPECT_FALSE(fit_along(std::vector<Vector3d>{{0, 1, 0}, {1, 2, 0}}, std::vector<double>{0, 0}, axis));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(fit_along(std::vector<Vector3d>{{nan, 1, 0}, {1, 2, 0}}, std::vector<double>{1, 1}, axis));
}

TEST(BlendDirections, RunsFromForearmToSight) {
    const Vector3d forearm = Vector3d::UnitY(), tip(0, 0.7, 1.2), eye(0, 0, 1.6);
    const Vector3d sight = (tip - eye).normalized();
    EXPECT_LT((blend_directions(forearm, eye, tip, 0) - forearm).norm(), 1e-12);
    EXPECT_LT((blend_directions(forearm, eye, tip, 1) - sight).norm(), 1e-12);
    const Vector3d middle = blend_directions(forearm, eye, tip, 0.5);
    EXPECT_NEAR(middle.norm(), 1, 1e-12);
    EXPECT_NEAR(middle.dot(forearm), middle.dot(sight), 1e-9);
    EXPECT_LT((blend_directions(forearm, tip, tip, 1) - forearm).norm(), 1e-12);
}

TEST(SpotOnPart, IsTheCutOfTheRayInThePartFrame) {
    const RayCaster caster = caster_of(panel(0.8F, 0.3F));
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(-1, 1);
    PointingParams sure, far;
    sure.direction_sigma_deg = 0;
    far.direction_sigma_deg = 5;
    far.closeness_m = 10;
    for (int i = 0; i < 200; ++i) {
        RigidTransform world_from_part;
        world_from_part.rotation = Eigen::AngleAxisd(3 * unit(random), Vector3d::UnitZ()).toRotationMatrix();
        world_from_part.translation = Vector3d(unit(random), unit(random), 1 + 0.3 * unit(random));
        const Vector3d target(0.6 * unit(random), 0, 0.2 * unit(random)),
            from(target.x() + 0.1 * unit(random), -0.2, target.z() + 0.1 * unit(random));
        const Vector3d origin = world_from_part * from;
        const Vector3d direction = world_from_part.rotation * (target - from).normalized();
        const auto exact = spot_on_part(caster, world_from_part, origin, direction, sure);
        ASSERT_TRUE(exact);
        EXPECT_LT((exact->spot.position - target).norm(), 1e-4);
        EXPECT_NEAR(exact->distance_m, (target - from).norm(), 1e-4);
        EXPECT_FALSE(exact->snapped);
        EXPECT_FALSE(exact->touch);
        EXPECT_LT((exact->spot.normal - Vector3d(0, -1, 0)).norm(), 1e-5);  // looks at the worker
        const auto averaged = spot_on_part(caster, world_from_part, origin, direction, far);
        ASSERT_TRUE(averaged);
        EXPECT_LT((averaged->spot.position - target).norm(), 0.012);
        // Across a slanted ray the prior that fingers come close draws the mean towards the fingertip.
        const auto drawn = spot_on_part(caster, world_from_part, origin, direction, {});
        ASSERT_TRUE(drawn);
        EXPECT_LT((drawn->spot.position - target).norm(), 0.04);
    }
}

TEST(SpotOnPart, NormalLooksAtTheWorkerHoweverTheMeshIsWound) {
    SurfaceMesh mesh = panel(0.8F, 0.3F);
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    const auto spot = spot_on_part(caster_of(mesh), {}, {0, -0.3, 0}, {0, 1, 0}, {});
    ASSERT_TRUE(spot);
    EXPECT_LT((spot->spot.normal - Vector3d(0, -1, 0)).norm(), 1e-5);
}

TEST(SpotOnPart, ANearMissSnapsToTheEdgeAndAFarOneIsNone) {
    const RayCaster caster = caster_of(panel(0.8F, 0.3F));
    PointingParams params;
    params.direction_sigma_deg = 0;
    const auto snapped = spot_on_part(caster, {}, {0.84, -0.3, 0.1}, {0, 1, 0}, params);
    ASSERT_TRUE(snapped);
    EXPECT_TRUE(snapped->snapped);
    EXPECT_LT((snapped->spot.position - Vector3d(0.8, 0, 0.1)).norm(), 1e-4);
    EXPECT_FALSE(spot_on_part(caster, {}, {0.95, -0.3, 0.1}, {0, 1, 0}, params));
    EXPECT_FALSE(spot_on_part(caster, {}, {0, -0.3, 0}, {0, -1, 0}, params));
    EXPECT_FALSE(spot_on_part(caster, {}, {0, -1.3, 0}, {0, 1, 0}, params));
}

TEST(SpotOnPart, OnAGrazedSurfaceTheSpotStaysNearTheFingertip) {
    // A ray that comes down on the panel at 6 degrees meets it far away; a degree more or less is 8 cm there.
    const RayCaster caster = caster_of(panel(0.8F, 0.3F));
    const double slant = 6 * std::numbers::pi / 180;
    const Vector3d tip(-0.4, -0.06, 0), direction(std::cos(slant), std::sin(slant), 0);
    const double cut = -0.4 + 0.06 / std::tan(slant);
    const auto spot = spot_on_part(caster, {}, tip, direction, {});
    ASSERT_TRUE(spot);
    EXPECT_LT(spot->spot.position.x(), cut - 0.2);
    EXPECT_GT(spot->spot.position.x(), tip.x());
    EXPECT_NEAR(spot->spot.position.z(), 0, 0.005);
    PointingParams sure;
    sure.direction_sigma_deg = 0;
    const auto exact = spot_on_part(caster, {}, tip, direction, sure);
    ASSERT_TRUE(exact);
    EXPECT_NEAR(exact->spot.position.x(), cut, 1e-4);
}

TEST(SpotOnPart, ARayBesideThePartMeansNothingHoweverWideTheCone) {
    const RayCaster caster = caster_of(panel(0.8F, 0.3F));
    const double past = 10 * std::numbers::pi / 180;  // inside the cone of two deviations, but off the part
    EXPECT_FALSE(spot_on_part(caster, {}, {0.8, -0.5, 0.1}, {std::sin(past), std::cos(past), 0}, {}));
}

TEST(SpotOnPart, ATipAtOrJustBehindTheSurfaceTouches) {
    const RayCaster caster = caster_of(panel(0.8F, 0.3F));
    for (const double y : {-0.03, -0.005, 0.01, 0.03}) {
        const auto spot = spot_on_part(caster, {}, {0.1, y, 0.1}, {0, 1, 0}, {});
        ASSERT_TRUE(spot) << y;
        EXPECT_TRUE(spot->touch);
        EXPECT_LT((spot->spot.position - Vector3d(0.1, 0, 0.1)).norm(), 0.01);
    }
}

TEST(SpotOnPart, RefusesWhatIsNoRay) {
    const RayCaster caster = caster_of(panel(0.8F, 0.3F));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(spot_on_part(caster, {}, {nan, -0.3, 0}, {0, 1, 0}, {}));
    EXPECT_FALSE(spot_on_part(caster, {}, {0, -0.3, 0}, {0, nan, 0}, {}));
    EXPECT_FALSE(spot_on_part(caster, {}, {0, -0.3, 0}, {0, 0, 0}, {}));
    RayCaster empty;
    empty.commit();
    EXPECT_FALSE(spot_on_part(empty, {}, {0, -0.3, 0}, {0, 1, 0}, {}));
}

TEST(PointingParams, NameWhatIsOutOfRange) {
    EXPECT_TRUE(PointingParams{}.validate().empty());
    PointingParams params;
    params.eye_weight = 1.1;
    params.direction_sigma_deg = 21;
    EXPECT_EQ(params.validate().size(), 2U);
}

}  // namespace
}  // namespace deixis
