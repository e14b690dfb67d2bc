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
/// SurfacePoints of the same frame, rising. Both are empty, and the rest means nothing, when `present` is
/// false.
struct WorkerBody {
    bool present = false;
    std::vector<uint32_t> voxels;
    std::vector<uint32_t> points;
    VoxelLattice lattice;
    Eigen::Vector3f head_top =
        Eigen::Vector3f::Zero();  ///< top of the skull, over the middle of the seen head [m]
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();  ///< middle of the seen trunk [m]
    float height = 0;                                  ///< standing height as known so far [m]
};

/// Occupied voxels with foreground points that are not the part's, and the occupied voxels that touch those,
/// fall into components (26 neighbours). A person is an upright component 1.2 to 2.2 m tall; small components
/// near it and clear of the floor are his too (a forearm behind an edge). What stands or hangs on its own and
/// is no person, such as the trolley and its bars, is remembered as clutter until its place is seen free, and
/// is cut out of the worker when he touches it; nothing near a person is learned. Deterministic; no
/// allocation once warm.
class WorkerVolume {
  public:
    struct Params {
        int min_points = 2;         ///< foreground points that a voxel needs
        int outvoting_points = 4;   ///< points that a voxel needs which a sensor sees as free
        int min_voxels = 150;       ///< of a person
        double min_height_m = 1.2;  ///< of a person [m]
        double max_height_m = 2.2;  ///< [m]
        double attach_m = 0.15;     ///< small components this near to the person are his [m]
        double clutter_s = 0.5;     ///< a thing this long on its own is clutter [s]

        InvalidSettings validate() const;
    };

    explicit WorkerVolume(Params params);

    /// `part_points` has one entry a surface point, non-zero = the part's (within 3-4 cm of its CAD surface);
    /// another length = no part is known. `grid` and `points` are those of one frameset.
    const WorkerBody& update(int64_t timestamp_us, const VoxelGrid& grid, const SurfacePoints& points,
                             std::span<const uint8_t> part_points);

    const WorkerBody& body() const { return body_; }

    /// Voxels that are remembered as things, rising.
    std::vector<uint32_t> clutter() const;

  private:
    struct Component {
        size_t first = 0, count = 0;  ///< range of order_
        Eigen::Vector3f min = Eigen::Vector3f::Zero(), max = Eigen::Vector3f::Zero();
        bool of_worker = false;
        bool at_part = false;  ///< touches voxels of the part: what holds it, or its own noise
    };

    void start_afresh(const VoxelGrid& grid);
    void gather(const VoxelGrid& grid, const SurfacePoints& points, std::span<const uint8_t> part_points);
    void label(const VoxelLattice& lattice);
    int choose_person(const VoxelLattice& lattice) const;
    bool is_upright(const VoxelLattice& lattice, const Component& component) const;
    void attach(const VoxelLattice& lattice, int person);
    void mark_person_blocks(const VoxelLattice& lattice, float seconds);
    bool is_near_person(const VoxelLattice& lattice, size_t voxel) const;
    void remember_clutter(const VoxelGrid& grid, float seconds);
    void collect(const SurfacePoints& points);
    void measure(const SurfacePoints& points);

    Params params_;
    WorkerBody body_;
    std::vector<uint16_t> own_points_;   ///< by voxel: foreground points that are not the part's
    std::vector<uint16_t> part_voxels_;  ///< by voxel: points of the part
    std::vector<int32_t> labels_;        ///< by voxel: -1 idle, -2 active, else component
    std::vector<int64_t> point_voxels_;  ///< by point: its voxel, -1 = not the worker's for sure
    std::vector<uint32_t> touched_;      ///< voxels to reset
    std::vector<uint32_t> active_;
    std::vector<uint32_t> order_;  ///< active voxels, component by component
    std::vector<Component> components_;
    std::vector<float> clutter_s_;  ///< by voxel: seconds as part of a thing
    std::vector<uint32_t> clutter_voxels_;
    Eigen::Vector3i blocks_ = Eigen::Vector3i::Zero();
    std::vector<uint8_t> near_person_;  ///< by block of voxels
    float person_seen_s_ = 0;           ///< seconds since a person was seen
    std::vector<float> heights_;
    bool started_ = false;
    int64_t last_us_ = 0;
};

}  // namespace deixis
