// ICP: laws, and agreement with a plain version that searches every reference point.
#include "tracking/part/icp.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "tests/tracking/part/synthetic_cell.h"

namespace deixis {
namespace {

using namespace synthetic;

RigidTransform random_pose(std::mt19937& random, double angle, double shift) {
    std::uniform_real_distribution<double> u(-1, 1);
    const Eigen::Vector3d axis = Eigen::Vector3d(u(random), u(random), u(random)).normalized();
    return {Eigen::AngleAxisd(angle, axis).toRotationMatrix(),
            shift * Eigen::Vector3d(u(random), u(random), u(random)).normalized()};
}

/// Points of the skin that a viewer in front sees, with noise.
std::vector<ScenePoint> seen_points(const ReferenceModel& model, const RigidTransform& world_from_part,
                                    double sigma) {
    std::mt19937 random(9);
    std::normal_distribution<float> noise(0, static_cast<float>(sigma));
    std::vector<ScenePoint> points;
    const Eigen::Vector3f eye(0.5F, -3, 1);
    for (size_t i = 0; i < model.fine().size(); i += 5) {
        const SkinPoint& p = model.fine()[i];
        const Eigen::Vector3f to_eye = (eye - p.position).normalized();
        if (p.normal.dot(to_eye) < 0.3F || !p.visible_from.test(skin_direction_index(to_eye))) continue;
        const Eigen::Vector3f q = p.position + noise(random) * to_eye;
        points.push_back({(world_from_part * q.cast<double>()).cast<float>(),
                          (world_from_part.rotation * to_eye.cast<double>()).cast<float>(), 1});
    }
    return points;
}

/// The same method by plain loops: nearest of all facing points, Tukey's weights, normal equations in
/// doubles.
RigidTransform plain_icp(const std::vector<ScenePoint>& points, const ReferenceModel& model,
                         RigidTransform guess, double gate, int iterations) {
    RigidTransform part_from_world = guess.inverse();
    for (int i = 0; i < iterations; ++i) {
        Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
        Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
        for (const ScenePoint& s : points) {
            const Eigen::Vector3d p = part_from_world * s.position.cast<double>();
            const Eigen::Vector3d to_eye = part_from_world.rotation * s.to_eye.cast<double>();
            double best = std::numeric_limits<double>::max();
            const SkinPoint* q = nullptr;
            for (const SkinPoint& m : model.fine()) {
                const double d = (m.position.cast<double>() - p).squaredNorm();
                if (d < best && m.normal.cast<double>().dot(to_eye) > 0.1) best = d, q = &m;
            }
            const Eigen::Vector3d n = q->normal.cast<double>(), d = p - q->position.cast<double>();
            const double plane = d.dot(n);
            if (std::abs(plane) >= gate || (d - plane * n).norm() > 0.6 * gate) continue;
            const double w = std::pow(1 - plane * plane / (gate * gate), 2);
            Eigen::Matrix<double, 6, 1> row;
            row << p.cross(n), n;
            h += w * row * row.transpose();
            g += w * plane * row;
        }
        const Eigen::Matrix<double, 6, 1> x = -h.ldlt().solve(g);
        const Eigen::Vector3d turn = x.head<3>();
        part_from_world = RigidTransform{Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix(),
                                         x.tail<3>()} *
                          part_from_world;
    }
    return part_from_world.inverse();
}

class IcpTest : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        model_ = new std::shared_ptr<const ReferenceModel>(*ReferenceModel::build(bumper_shell(false), {}));
    }
    static void TearDownTestSuite() { delete model_; }
    static const ReferenceModel& model() { return **model_; }
    static inline std::shared_ptr<const ReferenceModel>* model_ = nullptr;
    const std::vector<IcpStep> steps_ = {{0.08, 10}, {0.03, 30}};
};

TEST_F(IcpTest, ComesBackFromAnyDirection) {
    std::mt19937 random(1);
    for (int i = 0; i < 12; ++i) {
        const RigidTransform truth = random_pose(random, 2.0, 1.5);
        RigidTransform off = random_pose(random, 0.05, 0.04);
        off.translation += model().centre() - off.rotation * model().centre();
        const IcpResult fit =
            register_points(seen_points(model(), truth, 0.004), model(), truth * off, steps_);
        EXPECT_LT(error_between(fit.world_from_part, truth).mm, 3);
        EXPECT_LT(error_between(fit.world_from_part, truth).degree, 0.2);
        EXPECT_GT(fit.weakest, 0.0015);
        EXPECT_LT(fit.rms, 0.006);
    }
}

TEST_F(IcpTest, AMovedSceneGivesTheMovedPose) {
    std::mt19937 random(2);
    const RigidTransform truth{Eigen::Matrix3d::Identity(), {0, 0.2, 0.8}};
    const RigidTransform guess = truth * random_pose(random, 0.02, 0.01);
    const auto points = seen_points(model(), truth, 0.005);
    const IcpResult before = register_points(points, model(), guess, steps_);
    for (int i = 0; i < 5; ++i) {
        const RigidTransform motion = random_pose(random, 1.1, 0.7);
        auto carried = points;
        for (ScenePoint& p : carried) {
            p.position = (motion * p.position.cast<double>()).cast<float>();
            p.to_eye = (motion.rotation * p.to_eye.cast<double>()).cast<float>();
        }
        const IcpResult after = register_points(carried, model(), motion * guess, steps_);
        EXPECT_LT(error_between(after.world_from_part, motion * before.world_from_part).mm, 0.3);
        EXPECT_LT(error_between(after.world_from_part, motion * before.world_from_part).degree, 0.02);
    }
}

TEST_F(IcpTest, AgreesWithThePlainLoop) {
    const RigidTransform truth{Eigen::Matrix3d::Identity(), {0, 0.2, 0.8}};
    std::mt19937 random(3);
    auto points = seen_points(model(), truth, 0.005);
    std::vector<ScenePoint> some;
    for (size_t i = 0; i < points.size(); i += 4) some.push_back(points[i]);
    const RigidTransform guess = truth * random_pose(random, 0.01, 0.01);
    const RigidTransform plain = plain_icp(some, model(), guess, 0.03, 12);
    const IcpResult fit = register_points(some, model(), guess, {{0.03, 12}});
    EXPECT_LT(error_between(fit.world_from_part, plain).mm, 1.0);
    EXPECT_LT(error_between(fit.world_from_part, plain).degree, 0.06);
}

TEST_F(IcpTest, APlainArcCanSlide) {
    std::vector<Eigen::Vector2f> profile;
    for (int i = 0; i <= 20; ++i) {
        const float t = static_cast<float>(i) / 20;
        profile.emplace_back(0.12F * t * t - 0.05F * std::sin(3 * t), 0.4F * t);
    }
    ReferenceModelParams params;
    params.fine_spacing = 0.02;
    const auto plain = ReferenceModel::build(extruded_shell(profile, 1.7F, 2.5F), params);
    ASSERT_TRUE(plain);
    const auto points = seen_points(**plain, {}, 0.004);
    EXPECT_LT(register_points(points, **plain, {}, steps_).weakest, 0.0008);
}

TEST_F(IcpTest, FewOrForeignPointsChangeNothing) {
    const RigidTransform guess{Eigen::Matrix3d::Identity(), {1, 2, 3}};
    const IcpResult none = register_points({}, model(), guess, steps_);
    EXPECT_EQ(none.pairs, 0);
    EXPECT_FALSE(none.converged);
    EXPECT_LT(error_between(none.world_from_part, guess).mm, 1e-6);
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    const std::vector<ScenePoint> broken(500, {{nan, nan, nan}, {0, 0, 1}, 1});
    EXPECT_EQ(register_points(broken, model(), guess, steps_).pairs, 0);
}

}  // namespace
}  // namespace deixis
