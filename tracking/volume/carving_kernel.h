// The inner loop of carving, dispatched at run time to the widest SIMD of the machine.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tracking/volume/carving.h"
#include "tracking/volume/voxel_grid.h"

namespace deixis {

/// slack(D) = constant + per_m2 * D * D [m].
struct CarvingMargins {
    float slack_constant = 0;
    float slack_per_m2 = 0;
    float penetration = 0;
};

/// Writes the state of every voxel. The projection is, in this order and in float without fused operations,
/// P0*x + (P1*y + (P2*z + P3)) a row, times 1 / z (one true division), the lens, then floor(f*x + c + 0.5).
void carve(std::span<const CarvingView* const> views, const VoxelLattice& lattice,
           const CarvingMargins& margins, std::vector<uint8_t>& states);

}  // namespace deixis
