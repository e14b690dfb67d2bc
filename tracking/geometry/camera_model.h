// Pinhole camera with the Brown-Conrady lens: 3D points of the camera frame to raw pixels and back.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace deixis {

/// Conventions of thesis 2.1 and OpenCV: x right, y down, z along the optical axis; the centre of the
/// top-left pixel is (0, 0); no skew (gamma of eq. 2.2 is zero).
struct CameraModel {
    int width = 0;
    int height = 0;
    double fx = 0, fy = 0;                               ///< [pixel]
    double cx = 0, cy = 0;                               ///< [pixel]
    std::array<double, 5> distortion = {0, 0, 0, 0, 0};  ///< k1, k2, p1, p2, k3 (eq. 2.3-2.4)

    bool has_distortion() const;

    /// Pixel of a point with z > 0 [m]; may lie outside the image.
    Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const;

    /// The point (x, y, 1) that projects to `pixel`: distortion undone by Newton's method, error below 1e-9
    /// of the focal length for lenses that are invertible over the image.
    Eigen::Vector3d ray(const Eigen::Vector2d& pixel) const;

    /// `ray` of every pixel centre, row-major, as (x, y): z times it is the point of a depth pixel.
    std::vector<Eigen::Vector2f> ray_table() const;
};

}  // namespace deixis
