// Rays against one or more triangle meshes (Embree inside): pointing hits, simulator, occlusion maps.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>

#include "tracking/geometry/surface_mesh.h"

namespace deixis {

struct RayHit {
    float distance = 0;  ///< in units of the direction's length
    uint32_t mesh = 0;   ///< index as returned by `add`
    uint32_t triangle = 0;
    Eigen::Vector3f normal;  ///< unit, as the triangle is wound, not turned to the viewer
};

struct NearestPoint {
    Eigen::Vector3f position;
    Eigen::Vector3f normal;  ///< unit normal of the nearest triangle as wound
    float distance = 0;      ///< [m]
    uint32_t mesh = 0;
    uint32_t triangle = 0;
};

/// Frame and unit are those of the meshes. `add` and `update` are followed by `commit` before the next query.
/// Queries may run from several threads at once; results do not depend on the thread count.
class RayCaster {
  public:
    RayCaster();
    ~RayCaster();
    RayCaster(RayCaster&&) noexcept;
    RayCaster& operator=(RayCaster&&) noexcept;

    /// Copies the mesh in; returns its index, counted from 0.
    uint32_t add(const SurfaceMesh& mesh);

    /// Replaces the vertices of mesh `index`; same number as before.
    void update(uint32_t index, const std::vector<Eigen::Vector3f>& vertices);

    void commit();

    /// First hit with distance in [near, far]; nothing when the ray misses or has a NaN.
    std::optional<RayHit> cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                               float near = 0, float far = 1e30F) const;

    /// The surface point nearest to `p` within `radius`; nothing beyond it.
    std::optional<NearestPoint> nearest(const Eigen::Vector3f& p, float radius) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace deixis
