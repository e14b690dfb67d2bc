// The worker: what is left of the foreground without the part and without things. In: voxels, points; out:
// one person.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/volume/surface_points.h"
#include "tracking/volume/voxel_grid.h"

namespace deixis {

/// One person in the cell. `voxels` are indices of `lattice`, rising; `points` are indices into the
/// SurfacePoints of the same frame, rising. Meaningless but for `voxels` and `points` (then empty) when
/// `present` is false.
struct WorkerBody {
    bool present = false;
    std::vector<uint32_t> voxels;
    std::vector<uint32_t> points;
    VoxelLattice lattice;
    Eigen::Vector3f head_top =
        Eigen::Vector3f::Zero();  ///< top of the skull, centre of the head in x and y [m]
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();  ///< middle of the trunk [m]
    float height = 0;                                  ///< standing height as known so far [m]
};

/// Occupied foreground voxels with surface points that are not the part's fall into components (26
/// neighbours). A person is an upright component 1.2 to 2.2 m tall; smaller components near it belong to it
/// (a forearm behind an edge), unless they were seen as a thing of their own: what stays a component of its
/// own that is no person, such as the trolley, is remembered as clutter until its place is seen free again,
/// and is cut out of the worker when he touches it. Deterministic; no allocation once warm.
class WorkerVolume {
  public:
    struct Params {
        double min_height_m = 1.2;  ///< of a person [m]
        double max_height_m = 2.2;  ///< [m]
        double attach_m = 0.15;     ///< components this near to the person are his [m]
        double clutter_s = 0.5;     ///< a thing this long on its own is clutter [s]
        int min_voxels = 60;        ///< of a person

        InvalidSettings validate() const;
    };

    explicit WorkerVolume(Params params);

    /// `part_points` has one entry a surface point, non-zero = the part's (within 3-4 cm of its CAD surface);
    /// empty = no part is known. `grid` and `points` are those of one frameset.
    const WorkerBody& update(int64_t timestamp_us, const VoxelGrid& grid, const SurfacePoints& points,
                             std::span<const uint8_t> part_points);

    const WorkerBody& body() const { return body_; }

  private:
    struct Component {
        uint32_t first = 0, count = 0;  ///< range of order_
        Eigen::Vector3f min, max;
        bool is_person = false, is_attached = false;
    };

    void gather(const VoxelGrid& grid, const SurfacePoints& points, std::span<const uint8_t> part_points);
    void label(const VoxelLattice& lattice);
    void remember_clutter(int64_t timestamp_us, const VoxelGrid& grid);
    int choose_person(const VoxelLattice& lattice);
    void attach(const VoxelLattice& lattice, int person);
    void measure(const SurfacePoints& points);

    Params params_;
    WorkerBody body_;
    std::vector<uint8_t> flags_;    ///< by voxel: bits of this frame
    std::vector<int32_t> labels_;   ///< by voxel: component or -1
    std::vector<uint32_t> active_;  ///< voxels with a flag
    std::vector<uint32_t> order_;   ///< active voxels, component by component
    std::vector<Component> components_;
    std::vector<float> clutter_s_;  ///< by voxel: seconds as part of a thing
    std::vector<uint32_t> clutter_voxels_;
    int64_t last_us_ = 0;
    bool started_ = false;
};

}  // namespace deixis
