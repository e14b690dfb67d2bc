// The voxel grid: cubes of one size that fill a box of the world frame, one state each.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// free: a sensor sees through it; occupied: just behind a foreground surface; unknown: nobody can tell.
enum class VoxelState : uint8_t { free = 0, occupied = 1, unknown = 2 };

/// Where the voxels are. Index = (iz * ny + iy) * nx + ix. Voxel (0, 0, 0) has its lower corner at `corner`.
struct VoxelLattice {
    Eigen::Vector3f corner = Eigen::Vector3f::Zero();  ///< [m]
    float side = 0.03F;                                ///< [m]
    int nx = 0, ny = 0, nz = 0;

    /// The fewest voxels that cover the box.
    static VoxelLattice covering(const Box& box, double side) {
        VoxelLattice lattice;
        lattice.corner = box.min.cast<float>();
        lattice.side = static_cast<float>(side);
        const auto voxels = [&](int axis) {
            return static_cast<int>(std::ceil((box.max[axis] - box.min[axis]) / side - 1e-6));
        };
        lattice.nx = std::max(voxels(0), 0);
        lattice.ny = std::max(voxels(1), 0);
        lattice.nz = std::max(voxels(2), 0);
        return lattice;
    }

    size_t size() const { return static_cast<size_t>(nx) * ny * nz; }
    size_t index(int ix, int iy, int iz) const { return (static_cast<size_t>(iz) * ny + iy) * nx + ix; }

    Eigen::Vector3i coordinates(size_t index) const {
        const auto plane = static_cast<size_t>(nx) * ny;
        return {static_cast<int>(index % nx), static_cast<int>(index % plane / nx),
                static_cast<int>(index / plane)};
    }

    Eigen::Vector3f centre(size_t i) const {
        return corner + side * (coordinates(i).cast<float>() + Eigen::Vector3f::Constant(0.5F));
    }

    /// Index of the voxel that holds `p`, or -1 outside (and for NaN).
    int64_t find(const Eigen::Vector3f& p) const {
        const Eigen::Vector3f q = (p - corner) / side;
        if (!(q.x() >= 0 && q.y() >= 0 && q.z() >= 0 && q.x() < static_cast<float>(nx) &&
              q.y() < static_cast<float>(ny) && q.z() < static_cast<float>(nz)))
            return -1;
        return static_cast<int64_t>(
            index(static_cast<int>(q.x()), static_cast<int>(q.y()), static_cast<int>(q.z())));
    }
};

struct VoxelGrid {
    VoxelLattice lattice;
    std::vector<uint8_t> states;  ///< VoxelState of each voxel, by index

    VoxelState state(size_t i) const { return static_cast<VoxelState>(states[i]); }
};

}  // namespace deixis
