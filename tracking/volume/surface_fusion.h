// Surface fusion: the depth images of all sensors as one oriented cloud in the world frame, flying pixels
// dropped.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/volume/foreground.h"
#include "tracking/volume/surface_points.h"

namespace deixis {

/// Foreground pixels all become points; the others every `stride` rows and columns. A point is kept inside
/// the cell and above `floor_m`. Normals come from the organised image by differences that do not cross a
/// depth edge. Deterministic, no allocation once warm.
class SurfaceFusion {
  public:
    struct Params {
        int stride = 2;                ///< of pixels that are not foreground, 1 to 16
        double floor_m = 0.03;         ///< nothing below this height [m]
        double max_depth_m = 6.0;      ///< nothing beyond this depth [m]
        int normal_reach = 4;          ///< pixels to each side for a normal, 1 to 16
        double step_per_m2 = 2.85e-3;  ///< disparity step [m/m^2]
        double edge_steps = 3.0;       ///< a depth jump of more steps (plus 2 cm) is an edge

        InvalidSettings validate() const;
    };

    /// Without a cell points are kept wherever they are, above the floor.
    SurfaceFusion(const std::vector<CalibratedSensor>& depth_sensors, std::optional<Box> cell, Params params);

    /// Sensors that are absent, or have another size than calibrated, give no points.
    const SurfacePoints& update(const Frameset& frameset, const ForegroundModel& foreground);

    const SurfacePoints& points() const { return points_; }

  private:
    struct PerSensor {
        int width = 0, height = 0;
        std::vector<Eigen::Vector2f> rays;
        Eigen::Matrix3f world_from_camera;
        Eigen::Vector3f place;
    };

    void fuse(size_t index, const DepthImage& depth, std::span<const uint8_t> mask);

    Params params_;
    std::optional<Box> cell_;
    std::vector<PerSensor> sensors_;
    SurfacePoints points_;
};

}  // namespace deixis
