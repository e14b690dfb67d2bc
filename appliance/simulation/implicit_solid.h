// Smooth unions of rounded cones and ellipsoids as signed distance, and their closed mesh by surface nets.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tracking/geometry/surface_mesh.h"

namespace deixis {

/// One primitive: a rounded cone from a (radius ra) to b (radius rb), or, with `ellipsoid`, centre a and half
/// axes b.
struct SolidPrimitive {
    bool ellipsoid = false;
    Eigen::Vector3f a, b;
    float ra = 0, rb = 0;
    uint8_t bone = 0;  ///< what it belongs to
};

/// Distance to one primitive [m], negative inside (a bound away from the surface for ellipsoids).
float distance_to(const SolidPrimitive& primitive, const Eigen::Vector3f& p);

/// Smooth union of all, fillets of about `fillet` [m].
float distance_to_union(const std::vector<SolidPrimitive>& primitives, const Eigen::Vector3f& p,
                        float fillet);

/// Closed mesh of the zero set, triangles outwards; `cell` is the grid's edge [m]. Source: Gibson,
/// Constrained elastic surface nets, 1998.
SurfaceMesh mesh_of_union(const std::vector<SolidPrimitive>& primitives, float fillet, float cell);

}  // namespace deixis
