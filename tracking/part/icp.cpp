// The loop of ICP: pair, weigh, solve six unknowns.
#include "tracking/part/icp.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace deixis {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double weak_eigenvalue = 1e-4;
constexpr float facing_cosine = 0.10F;
constexpr int fewest_pairs = 30;

struct NormalEquations {
    Matrix6d hessian = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    double weight = 0, squares = 0;
    int pairs = 0;
};

/// The reference point that `p` (part frame, seen from `to_eye`) belongs to.
const SkinPoint* partner(const ReferenceModel& model, const Eigen::Vector3f& p,
                         const Eigen::Vector3f& to_eye) {
    for (const NearestPointGrid* grid : {&model.outer_grid(), &model.inner_grid()}) {
        const uint32_t i = grid->find(p);
        if (i == NearestPointGrid::none) continue;
        const SkinPoint& q = model.fine()[i];
        if (q.normal.dot(to_eye) > facing_cosine) return &q;
    }
    return nullptr;
}

NormalEquations gather(const std::vector<ScenePoint>& points, const ReferenceModel& model,
                       const RigidTransform& part_from_world, double gate) {
    NormalEquations sum;
    const Eigen::Matrix3f rotation = part_from_world.rotation.cast<float>();
    const Eigen::Vector3f translation = part_from_world.translation.cast<float>();
    const Eigen::Vector3f centre = model.centre().cast<float>();
    const auto lever = static_cast<float>(1 / model.radius());
    const auto gate_f = static_cast<float>(gate);
    const float beside = std::max(0.6F * gate_f, 1.5F * static_cast<float>(model.params().fine_spacing));
    // Upper triangle in floats over blocks of points, blocks in doubles: fast, and exact enough for long
    // clouds.
    Eigen::Matrix<float, 6, 6> block = Eigen::Matrix<float, 6, 6>::Zero();
    Eigen::Matrix<float, 6, 1> block_gradient = Eigen::Matrix<float, 6, 1>::Zero();
    int in_block = 0;
    const auto flush = [&] {
        sum.hessian += block.cast<double>();
        sum.gradient += block_gradient.cast<double>();
        block.setZero();
        block_gradient.setZero();
        in_block = 0;
    };
    for (const ScenePoint& s : points) {
        const Eigen::Vector3f p = rotation * s.position + translation;
        const SkinPoint* q = partner(model, p, rotation * s.to_eye);
        if (q == nullptr) continue;
        const Eigen::Vector3f d = p - q->position;
        const float plane = d.dot(q->normal);
        if (std::abs(plane) >= gate_f || (d - plane * q->normal).squaredNorm() > beside * beside) continue;
        const float relative = plane / gate_f, tukey = 1 - relative * relative;
        const float weight = s.weight * tukey * tukey;
        Eigen::Matrix<float, 6, 1> row;
        const Eigen::Vector3f n = q->normal, arm = lever * (p - centre);
        row << arm.y() * n.z() - arm.z() * n.y(), arm.z() * n.x() - arm.x() * n.z(),
            arm.x() * n.y() - arm.y() * n.x(), n;
        block.noalias() += weight * row * row.transpose();
        block_gradient += weight * plane * row;
        sum.weight += static_cast<double>(weight);
        sum.squares += static_cast<double>(weight * plane * plane);
        ++sum.pairs;
        if (++in_block == 256) flush();
    }
    flush();
    return sum;
}

}  // namespace

IcpResult register_points(const std::vector<ScenePoint>& points, const ReferenceModel& model,
                          const RigidTransform& guess, const std::vector<IcpStep>& steps) {
    IcpResult result;
    RigidTransform part_from_world = guess.inverse();
    for (const IcpStep& step : steps) {
        result.converged = false;
        for (int i = 0; i < step.iterations; ++i) {
            const NormalEquations sum = gather(points, model, part_from_world, step.gate);
            result.pairs = sum.pairs;
            if (sum.pairs < fewest_pairs || !(sum.weight > 0)) {
                result.world_from_part = part_from_world.inverse();
                return result;
            }
            result.rms = std::sqrt(sum.squares / sum.weight);
            const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(sum.hessian / sum.weight);
            const Vector6d along = solver.eigenvectors().transpose() * (sum.gradient / sum.weight);
            Vector6d move = Vector6d::Zero();
            for (int k = 0; k < 6; ++k)
                if (solver.eigenvalues()[k] > weak_eigenvalue)
                    move -= solver.eigenvectors().col(k) * (along[k] / solver.eigenvalues()[k]);
            result.weakest = solver.eigenvalues()[0];
            result.weakest_direction = solver.eigenvectors().col(0);
            const Eigen::Vector3d turn = move.head<3>() / model.radius();
            const Eigen::Vector3d shift = move.tail<3>();
            const double angle = std::min(turn.norm(), 0.2);
            const Eigen::Matrix3d rotation =
                angle > 0 ? Eigen::AngleAxisd(angle, turn.normalized()).toRotationMatrix()
                          : Eigen::Matrix3d::Identity();
            // p -> centre + rotation (p - centre) + shift, in the part's frame.
            const RigidTransform correction{rotation, model.centre() - rotation * model.centre() + shift};
            part_from_world = correction * part_from_world;
            if (angle * model.radius() + shift.norm() < 1e-4) {
                result.converged = true;
                break;
            }
        }
    }
    part_from_world.rotation = nearest_rotation(part_from_world.rotation);
    result.world_from_part = part_from_world.inverse();
    return result;
}

}  // namespace deixis
