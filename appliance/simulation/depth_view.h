// What one sensor would see without noise: layers of depth, slant and projector shadow, cast with Embree.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tracking/geometry/ray_caster.h"
#include "tracking/geometry/rigid_transform.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// Row-major over the sensor's raw (distorted) pixels.
struct DepthLayer {
    std::vector<float> z;         ///< along the optical axis [m]; infinity = nothing hit
    std::vector<float> cosine;    ///< between ray and surface normal, 0 to 1
    std::vector<uint8_t> shaded;  ///< 1 = the infrared projector does not reach the spot
};

/// A body to cast against: its caster's frame moves by `world_from_object`.
struct ViewedObject {
    const RayCaster* caster = nullptr;
    RigidTransform world_from_object;
};

/// Pixel rectangle, `to` exclusive.
struct PixelBox {
    int u0 = 0, v0 = 0, u1 = 0, v1 = 0;
    bool empty() const { return u0 >= u1 || v0 >= v1; }
};

/// Structured light: the projector stands `baseline` to the sensor's right; what it does not reach has no
/// depth.
class DepthView {
  public:
    explicit DepthView(const CalibratedSensor& sensor, double baseline = 0.075);

    /// An empty layer: nothing hit anywhere.
    DepthLayer empty_layer() const;

    /// Puts `object` in front of what `layer` shows; `below` are the objects already in it, for the shadows
    /// that they cast on `object`. Only pixels in `box` are touched. Results do not depend on `box` if it
    /// covers `footprint`.
    void overlay(DepthLayer& layer, const ViewedObject& object, const std::vector<ViewedObject>& below,
                 const PixelBox& box) const;

    /// How far to the left of an object `z` metres away its shadow can fall [pixel].
    int shadow_reach(double z) const;

    /// Pixels that `points` (world frame) or the shadow behind them can cover.
    PixelBox footprint(const std::vector<Eigen::Vector3f>& points,
                       const RigidTransform& world_from_points) const;

    PixelBox whole() const { return {0, 0, sensor_.camera.width, sensor_.camera.height}; }
    int width() const { return sensor_.camera.width; }
    int height() const { return sensor_.camera.height; }

  private:
    CalibratedSensor sensor_;
    double baseline_;
    Eigen::Vector3f eye_, projector_;  ///< world
    std::vector<Eigen::Vector3f>
        ray_;  ///< world, z of the camera frame = 1, so that a ray's parameter is its depth
};

}  // namespace deixis
