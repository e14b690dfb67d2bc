// A rigid motion between two frames. Variables are named b_from_a: b_from_a * p_a = p_b.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace deixis {

struct RigidTransform {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();

    Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation * p + translation; }

    RigidTransform operator*(const RigidTransform& b_from_a) const {
        return {rotation * b_from_a.rotation, rotation * b_from_a.translation + translation};
    }

    RigidTransform inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

/// Angle of the rotation between two poses [rad], 0 to pi.
inline double rotation_between(const RigidTransform& a, const RigidTransform& b) {
    const Eigen::Matrix3d difference = a.rotation.transpose() * b.rotation;
    return std::acos(std::clamp((difference.trace() - 1.0) / 2.0, -1.0, 1.0));
}

/// Nearest rotation matrix in the Frobenius norm; heals the drift of long products.
inline Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1.0;
    return u * svd.matrixV().transpose();
}

}  // namespace deixis
