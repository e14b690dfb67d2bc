// The worker's body: proportions, kinematics, skin.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <random>

#include "appliance/simulation/arm_goal.h"
#include "appliance/simulation/body_skeleton.h"
#include "appliance/simulation/body_surface.h"
#include "tests/appliance/simulation/small_cell.h"
#include "tracking/geometry/ray_caster.h"

namespace deixis {
namespace {

using Eigen::Vector3d;

Vector3d random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

/// Edges that are not shared by exactly two triangles of opposite direction.
size_t open_edges(const SurfaceMesh& mesh) {
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (const auto& t : mesh.triangles)
        for (int i = 0; i < 3; ++i) {
            const uint32_t a = t[i], b = t[(i + 1) % 3];
            edges[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    return static_cast<size_t>(
        std::count_if(edges.begin(), edges.end(), [](const auto& e) { return e.second != 0; }));
}

double volume_of(const SurfaceMesh& mesh) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        sum += mesh.vertices[a].cast<double>().dot(
                   mesh.vertices[b].cast<double>().cross(mesh.vertices[c].cast<double>())) /
               6;
    return sum;
}

TEST(Body, SegmentsFollowDrillisAndContini) {
    const BodyDimensions d{.height = 1.8, .girth = 1.0};
    const BodyPlaces places = place_body(d, rest_pose(d));
    const auto& j = places.joints;
    EXPECT_NEAR(j[0].z(), 1.8, 1e-9);
    for (size_t side = 0; side < 2; ++side) {
        EXPECT_NEAR((j[4 + side] - j[2 + side]).norm(), 0.186 * 1.8, 1e-9);
        EXPECT_NEAR((j[6 + side] - j[4 + side]).norm(), 0.146 * 1.8, 1e-9);
        EXPECT_NEAR((j[11 + side] - j[9 + side]).norm(), 0.245 * 1.8, 1e-3);
        EXPECT_NEAR((j[13 + side] - j[11 + side]).norm(), 0.246 * 1.8, 1e-3);
        EXPECT_NEAR(j[13 + side].z(), 0.039 * 1.8, 1e-9);
    }
    EXPECT_LT(j[2].x(), j[3].x()) << "left is at -x when facing +y";
    EXPECT_NEAR(j[8].z(), 0.53 * 1.8, 1e-9);
}

TEST(Body, RestPoseMovesNothing) {
    const BodyDimensions d;
    const BodySurface surface(d, 0.04);
    std::vector<Eigen::Vector3f> moved;
    surface.move(place_body(d, rest_pose(d)), moved);
    ASSERT_EQ(moved.size(), surface.rest_mesh().vertices.size());
    for (size_t i = 0; i < moved.size(); ++i)
        ASSERT_LT((moved[i] - surface.rest_mesh().vertices[i]).norm(), 1e-5F);
}

TEST(Body, SkinIsClosedAndWeighsWhatAPersonWeighs) {
    for (const double girth : {0.9, 1.0, 1.18}) {
        const BodyDimensions d{.height = 1.75, .girth = girth};
        const BodySurface surface(d);
        EXPECT_EQ(open_edges(surface.rest_mesh()), 0U);
        const double kilograms = 1010 * volume_of(surface.rest_mesh());
        EXPECT_GT(kilograms, 48 * girth);
        EXPECT_LT(kilograms, 92 * girth);
        const MeshBounds b = bounds_of(surface.rest_mesh());
        EXPECT_NEAR(b.max.z(), 1.75F, 0.02F);
        EXPECT_NEAR(b.min.z(), 0.0F, 0.02F);
    }
}

TEST(Body, StretchedFingerEndsAtTheFingertip) {
    const BodyDimensions d;
    BodyPose pose = rest_pose(d);
    for (ArmPose& arm : pose.arms) arm = {Vector3d::UnitY(), Vector3d::UnitY(), Vector3d::UnitY(), 1};
    const BodyPlaces places = place_body(d, pose);
    BodySurface surface(d);
    std::vector<Eigen::Vector3f> moved;
    surface.move(places, moved);
    for (size_t side = 0; side < 2; ++side) {
        float foremost = -1e9F;
        for (const Eigen::Vector3f& v : moved)
            if ((v.x() < 0) == (side == 0)) foremost = std::max(foremost, v.y());
        EXPECT_NEAR(foremost, places.fingertips[side].y(), 0.004);
    }
    for (ArmPose& arm : pose.arms) arm.pointing = 0;
    surface.move(place_body(d, pose), moved);
    float foremost = -1e9F;
    for (const Eigen::Vector3f& v : moved) foremost = std::max(foremost, v.y());
    EXPECT_LT(foremost, places.fingertips[0].y() - 0.05) << "a fist is shorter than a stretched finger";
}

TEST(Body, TwoBonesReachEveryPlaceInReach) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(0.15, 0.99);
    for (int i = 0; i < 500; ++i) {
        const Vector3d root = random_direction(random), pole = random_direction(random);
        const Vector3d end = root + 0.6 * share(random) * random_direction(random);
        const TwoBoneDirections r = reach_with_two_bones(root, end, 0.32, 0.28, pole);
        ASSERT_TRUE(r.reached);
        ASSERT_LT((root + 0.32 * r.first + 0.28 * r.second - end).norm(), 1e-9);
        const Vector3d joint = 0.32 * r.first, along = (end - root).normalized();
        ASSERT_GE((joint - along * along.dot(joint)).dot(pole), -1e-9) << "the joint bends towards the pole";
    }
    EXPECT_FALSE(reach_with_two_bones(Vector3d::Zero(), {0, 0, 1}, 0.32, 0.28, Vector3d::UnitX()).reached);
    EXPECT_FALSE(reach_with_two_bones(Vector3d::Zero(), {0, 0, 0.01}, 0.32, 0.28, Vector3d::UnitX()).reached);
    EXPECT_TRUE(reach_with_two_bones(Vector3d::Zero(), Vector3d::Zero(), 0.3, 0.3, Vector3d::UnitX())
                    .first.allFinite());
}

TEST(Body, BlendedDirectionsStayUnitAndMeetTheirEnds) {
    std::mt19937 random(4);
    for (int i = 0; i < 200; ++i) {
        const Vector3d a = random_direction(random),
                       b = i % 10 == 0 ? Vector3d(-a) : random_direction(random);
        EXPECT_LT((blend_directions(a, b, 0) - a).norm(), 1e-9);
        EXPECT_LT((blend_directions(a, b, 1) - b).norm(), 1e-6);
        EXPECT_NEAR(blend_directions(a, b, 0.3).norm(), 1, 1e-9);
    }
}

class Aims : public testing::TestWithParam<AimMode> {};

TEST_P(Aims, PutTheSpotOnTheirLine) {
    const BodyDimensions d;
    for (size_t side = 0; side < 2; ++side)
        for (const double gap : {0.05, 0.15, 0.3}) {
            BodyPose pose = rest_pose(d);
            ArmSurroundings around;
            const Vector3d shoulder = shoulder_of(d, pose, side);
            const Vector3d spot =
                shoulder + (0.94 * d.arm_reach() + gap) * Vector3d(0.1, 0.85, -0.5).normalized();
            const ArmGoal goal{
                .task = ArmTask::aim, .spot = spot, .mode = GetParam(), .gap = gap, .wrist_bend = 0.15};
            const ArmSolution solution = solve_arm(d, pose, side, goal, around);
            ASSERT_TRUE(solution.reached);
            pose.arms[side] = solution.arm;
            const BodyPlaces places = place_body(d, pose);
            const Vector3d tip = places.fingertips[side], elbow = places.joints[4 + side],
                           wrist = places.joints[6 + side];
            constexpr double tremor = 0.005;  // of the raised hand
            EXPECT_NEAR((spot - tip).norm(), gap, tremor);
            if (GetParam() == AimMode::eye) {
                EXPECT_LT(distance_off_line(spot, places.eye, tip), tremor);
            }
            if (GetParam() == AimMode::forearm) {
                EXPECT_LT(distance_off_line(spot, elbow, wrist), tremor);
                EXPECT_LT(distance_off_line(tip, elbow, wrist), 1e-9);
            }
            if (GetParam() == AimMode::finger) {
                EXPECT_LT(distance_off_line(spot, wrist, tip), tremor);
                const double bend = std::acos((wrist - elbow).normalized().dot((tip - wrist).normalized()));
                EXPECT_NEAR(bend, 0.15, 0.01);
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Each, Aims, testing::Values(AimMode::eye, AimMode::forearm, AimMode::finger),
                         [](const auto& mode) { return std::string(name_of(mode.param)); });

}  // namespace
}  // namespace deixis
