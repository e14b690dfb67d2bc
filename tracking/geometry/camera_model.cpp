// Projection and its inverse for the Brown-Conrady lens.
#include "tracking/geometry/camera_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace deixis {
namespace {

Eigen::Vector2d distort(const std::array<double, 5>& d, const Eigen::Vector2d& u) {
    const double r2 = u.squaredNorm();
    const double radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
    return {u.x() * radial + 2 * d[2] * u.x() * u.y() + d[3] * (r2 + 2 * u.x() * u.x()),
            u.y() * radial + d[2] * (r2 + 2 * u.y() * u.y()) + 2 * d[3] * u.x() * u.y()};
}

Eigen::Matrix2d distort_jacobian(const std::array<double, 5>& d, const Eigen::Vector2d& u) {
    const double x = u.x(), y = u.y(), r2 = u.squaredNorm();
    const double radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
    const double slope = 2 * (d[0] + r2 * (2 * d[1] + r2 * 3 * d[4]));  // d radial / d(r2) * 2
    Eigen::Matrix2d j;
    j(0, 0) = radial + x * x * slope + 2 * d[2] * y + 6 * d[3] * x;
    j(0, 1) = x * y * slope + 2 * d[2] * x + 2 * d[3] * y;
    j(1, 0) = x * y * slope + 2 * d[2] * x + 2 * d[3] * y;
    j(1, 1) = radial + y * y * slope + 6 * d[2] * y + 2 * d[3] * x;
    return j;
}

}  // namespace

bool CameraModel::has_distortion() const {
    return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d& p_camera) const {
    Eigen::Vector2d u(p_camera.x() / p_camera.z(), p_camera.y() / p_camera.z());
    if (has_distortion()) u = distort(distortion, u);
    return {fx * u.x() + cx, fy * u.y() + cy};
}

Eigen::Vector3d CameraModel::ray(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d target((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
    Eigen::Vector2d u = target;
    if (has_distortion()) {
        for (int i = 0; i < 20; ++i) {
            const Eigen::Vector2d error = distort(distortion, u) - target;
            if (error.squaredNorm() < 1e-22) break;
            u -= distort_jacobian(distortion, u).inverse() * error;
        }
    }
    return {u.x(), u.y(), 1};
}

std::vector<Eigen::Vector2f> CameraModel::ray_table() const {
    std::vector<Eigen::Vector2f> table(static_cast<size_t>(width) * height);
    for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u)
            table[static_cast<size_t>(v) * width + u] = ray({u, v}).head<2>().cast<float>();
    return table;
}

}  // namespace deixis
