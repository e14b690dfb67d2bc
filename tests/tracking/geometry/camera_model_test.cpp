// Projection and ray are each other's inverse, for pinhole and for strong lenses.
#include "tracking/geometry/camera_model.h"

#include <gtest/gtest.h>

namespace deixis {
namespace {

CameraModel kinect(std::array<double, 5> distortion) {
    return {640, 480, 575.8, 575.8, 319.5, 239.5, distortion};
}

TEST(CameraModel, CentreOfTopLeftPixelIsZero) {
    const CameraModel camera = kinect({});
    const Eigen::Vector2d pixel = camera.project({-319.5 / 575.8 * 2, -239.5 / 575.8 * 2, 2});
    EXPECT_NEAR(pixel.x(), 0, 1e-9);
    EXPECT_NEAR(pixel.y(), 0, 1e-9);
}

TEST(CameraModel, RayUndoesProjectOverTheWholeImage) {
    for (const auto& distortion :
         {std::array<double, 5>{0, 0, 0, 0, 0}, std::array<double, 5>{-0.26, 0.09, 1e-3, -2e-3, 0.01},
          std::array<double, 5>{0.12, -0.05, 0, 0, 0}}) {
        const CameraModel camera = kinect(distortion);
        for (int v = 0; v < 480; v += 13)
            for (int u = 0; u < 640; u += 13) {
                const Eigen::Vector2d back = camera.project(2.7 * camera.ray({u, v}));
                EXPECT_NEAR(back.x(), u, 1e-6);
                EXPECT_NEAR(back.y(), v, 1e-6);
            }
    }
}

TEST(CameraModel, DistortionMatchesEquations23And24) {
    const CameraModel camera = kinect({0.1, 0.02, 0.003, 0.004, 0.005});
    const double x = 0.3, y = -0.2, r2 = x * x + y * y;
    const double radial = 1 + 0.1 * r2 + 0.02 * r2 * r2 + 0.005 * r2 * r2 * r2;
    const Eigen::Vector2d pixel = camera.project({x, y, 1});
    EXPECT_NEAR(pixel.x(), 575.8 * (x * radial + 2 * 0.003 * x * y + 0.004 * (r2 + 2 * x * x)) + 319.5, 1e-9);
    EXPECT_NEAR(pixel.y(), 575.8 * (y * radial + 0.003 * (r2 + 2 * y * y) + 2 * 0.004 * x * y) + 239.5, 1e-9);
}

}  // namespace
}  // namespace deixis
