// The skin of a part: oriented points of its mesh that can be seen from outside, each with the directions it
// is seen from.
#pragma once

#include <Eigen/Core>
#include <bitset>
#include <cstdint>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

/// Directions over the sphere that visibility is sampled for, evenly spread (Fibonacci), about 12 degrees
/// apart.
inline constexpr int skin_directions = 256;
using VisibleFrom = std::bitset<skin_directions>;

/// Unit vector of direction `index`, and the index of the direction nearest to a unit vector (table look-up,
/// within one spacing of the nearest).
const Eigen::Vector3f& skin_direction(int index);
int skin_direction_index(const Eigen::Vector3f& unit);

struct SkinPoint {
    Eigen::Vector3f position;  ///< [m], part frame
    Eigen::Vector3f normal;    ///< unit, away from the material, whatever the winding of the file
    VisibleFrom visible_from;  ///< bit i: nothing of the part stands between the point and a viewer far off
                               ///< in direction i
    bool outer = true;  ///< false: back side of a thin wall or sheet, the side that sees less of the world
};

struct OuterSkinParams {
    double spacing = 0.010;  ///< mean distance of samples [m]
    double openness_min =
        0.06;                 ///< share of the half space before a point that must be free for it to be seen
    double wall_max = 0.012;  ///< two open sides nearer than this are front and back of one wall [m]
    InvalidSettings validate() const;
};

/// Samples both sides of every triangle on a fixed pattern and keeps the sides that rays can leave: the
/// inside of closed walls, inner ribs and doubled triangles vanish. Winding, duplicate vertices and
/// degenerate triangles of the file do not matter. A sheet without thickness gives two points back to back.
/// Deterministic.
std::vector<SkinPoint> sample_outer_skin(const SurfaceMesh& mesh, const OuterSkinParams& params);

}  // namespace deixis
