// Limbs: branches of the worker's voxels, by path length from the head. In: worker voxels; out: what sticks
// out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/volume/worker_volume.h"

namespace deixis {

/// A branch of the body that ends in `tip`: voxels between which there is a path (eq. 5.1) that stays farther
/// from the head than where the branch meets a longer one.
struct Limb {
    uint32_t tip = 0;   ///< voxel farthest from the head along the body
    uint32_t root = 0;  ///< voxel where it meets a longer branch
    float length = 0;   ///< path length from root to tip [m]
    std::vector<uint32_t>
        voxels;  ///< with their path lengths to the tip, nearest first, at most c_max of eq. 5.2
    std::vector<float> to_tip;  ///< [m]
};

/// Finds limbs without a body model: path lengths from the head (Dijkstra over 26 neighbours, gaps bridged),
/// then the merge tree of their superlevel sets. An arm that touches the body merges where it touches; an arm
/// akimbo is a loop and no limb. Deterministic; no allocation once warm but for the limbs themselves.
class LimbFinder {
  public:
    struct Params {
        double min_length_m = 0.25;  ///< shorter branches are bumps [m]
        double max_length_m = 0.60;  ///< c_max of eq. 5.2, how much of a limb is kept [m]
        double bridge_m = 0.20;      ///< widest gap that a path crosses [m]

        InvalidSettings validate() const;
    };

    explicit LimbFinder(Params params);

    /// Limbs, longest first. Empty when nobody is there.
    const std::vector<Limb>& update(const WorkerBody& worker);

  private:
    void index_voxels(const WorkerBody& worker);
    void measure_paths(const WorkerBody& worker);
    bool bridge();
    void settle();
    void branch(const WorkerBody& worker);
    void add_limb(uint32_t tip, uint32_t root, const WorkerBody& worker);
    uint32_t find_set(uint32_t i);

    struct QueueEntry {
        float path = 0;
        uint32_t node = 0;
    };
    struct Neighbour {
        uint32_t node = 0;
        float step = 0;
    };

    Params params_;
    std::vector<Limb> limbs_;
    std::vector<int32_t> node_of_voxel_;
    std::vector<uint32_t> voxel_of_node_;
    std::vector<Eigen::Vector3f> centres_;
    std::vector<uint32_t> first_neighbour_;
    std::vector<Neighbour> neighbours_;
    std::vector<float> path_;  ///< from the head [m]
    std::vector<QueueEntry> queue_;
    std::vector<uint32_t> falling_;               ///< nodes by falling path length
    std::vector<uint32_t> parent_, peak_, base_;  ///< by node: set, its tip, where it first met a limb
    std::vector<std::pair<uint32_t, uint32_t>> bridges_;  ///< reached node, node across the gap
    std::vector<uint8_t> visited_;
    std::vector<uint32_t> flood_;
};

}  // namespace deixis
