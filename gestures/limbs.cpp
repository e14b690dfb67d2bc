// Path lengths over the worker's voxels and the merge tree of their superlevel sets.
#include "gestures/limbs.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deixis {
namespace {

constexpr float kUnreached = std::numeric_limits<float>::infinity();
constexpr float kHeadHeight = 0.22F;  // the head from its top [m]
constexpr float kHeadRadius = 0.20F;  // [m]
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

}  // namespace

InvalidSettings LimbFinder::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "min_length_m", min_length_m, 0.05, 1.0);
    require_range(complaints, "max_length_m", max_length_m, min_length_m, 2.0);
    require_range(complaints, "bridge_m", bridge_m, 0, 0.5);
    return complaints;
}

LimbFinder::LimbFinder(Params params) : params_(params) {}

const std::vector<Limb>& LimbFinder::update(const WorkerBody& worker) {
    limbs_.clear();
    index_voxels(worker);
    if (!worker.present || worker.voxels.empty()) return limbs_;
    measure_paths(worker);
    branch(worker);
    std::stable_sort(limbs_.begin(), limbs_.end(),
                     [](const Limb& a, const Limb& b) { return a.length > b.length; });
    return limbs_;
}

void LimbFinder::index_voxels(const WorkerBody& worker) {
    const VoxelLattice& lattice = worker.lattice;
    for (const uint32_t v : voxel_of_node_) {
        if (v < node_of_voxel_.size()) node_of_voxel_[v] = -1;
    }
    if (node_of_voxel_.size() != lattice.size()) node_of_voxel_.assign(lattice.size(), -1);
    voxel_of_node_.assign(worker.voxels.begin(), worker.voxels.end());
    centres_.clear();
    for (size_t n = 0; n < voxel_of_node_.size(); ++n) {
        node_of_voxel_[voxel_of_node_[n]] = static_cast<int32_t>(n);
        centres_.push_back(lattice.centre(voxel_of_node_[n]));
    }
    first_neighbour_.clear();
    neighbours_.clear();
    for (const uint32_t v : voxel_of_node_) {
        first_neighbour_.push_back(static_cast<uint32_t>(neighbours_.size()));
        const Eigen::Vector3i c = lattice.coordinates(v);
        for (int z = std::max(c.z() - 1, 0); z <= std::min(c.z() + 1, lattice.nz - 1); ++z)
            for (int y = std::max(c.y() - 1, 0); y <= std::min(c.y() + 1, lattice.ny - 1); ++y)
                for (int x = std::max(c.x() - 1, 0); x <= std::min(c.x() + 1, lattice.nx - 1); ++x) {
                    const int32_t n = node_of_voxel_[lattice.index(x, y, z)];
                    const int faces = std::abs(x - c.x()) + std::abs(y - c.y()) + std::abs(z - c.z());
                    if (n < 0 || faces == 0) continue;
                    neighbours_.push_back(
                        {static_cast<uint32_t>(n), lattice.side * std::sqrt(static_cast<float>(faces))});
                }
    }
    first_neighbour_.push_back(static_cast<uint32_t>(neighbours_.size()));
}

/// Dijkstra from whatever stands in the queue.
void LimbFinder::settle() {
    const auto later = [](const QueueEntry& a, const QueueEntry& b) {
        return a.path != b.path ? a.path > b.path : a.node > b.node;
    };
    std::make_heap(queue_.begin(), queue_.end(), later);
    while (!queue_.empty()) {
        std::pop_heap(queue_.begin(), queue_.end(), later);
        const QueueEntry entry = queue_.back();
        queue_.pop_back();
        if (entry.path > path_[entry.node]) continue;
        for (uint32_t k = first_neighbour_[entry.node]; k < first_neighbour_[entry.node + 1]; ++k) {
            const Neighbour& n = neighbours_[k];
            const float path = entry.path + n.step;
            if (path >= path_[n.node]) continue;
            path_[n.node] = path;
            queue_.push_back({path, n.node});
            std::push_heap(queue_.begin(), queue_.end(), later);
        }
    }
}

void LimbFinder::measure_paths(const WorkerBody& worker) {
    path_.assign(centres_.size(), kUnreached);
    queue_.clear();
    bridges_.clear();
    for (uint32_t n = 0; n < centres_.size(); ++n) {
        const Eigen::Vector3f from_top = centres_[n] - worker.head_top;
        if (from_top.z() < -kHeadHeight || from_top.head<2>().norm() > kHeadRadius) continue;
        path_[n] = 0;
        queue_.push_back({0, n});
    }
    settle();
    constexpr int kRounds = 4;  // a piece may hang on a piece
    for (int round = 0; round < kRounds && bridge(); ++round) settle();
}

/// Queues the unreached nodes within a bridge of reached ones; false when there are none.
bool LimbFinder::bridge() {
    const auto widest = static_cast<float>(params_.bridge_m);
    const size_t before = bridges_.size();
    for (uint32_t n = 0; n < centres_.size(); ++n) {
        if (path_[n] != kUnreached) continue;
        float best = kUnreached;
        uint32_t from = kNone;
        for (uint32_t m = 0; m < centres_.size(); ++m) {
            if (path_[m] == kUnreached) continue;
            const float gap = (centres_[m] - centres_[n]).norm();
            if (gap > widest || path_[m] + gap >= best) continue;
            best = path_[m] + gap;
            from = m;
        }
        if (from == kNone) continue;
        bridges_.emplace_back(from, n);
        queue_.push_back({best, n});
    }
    for (const QueueEntry& entry : queue_) path_[entry.node] = entry.path;
    return bridges_.size() > before;
}

uint32_t LimbFinder::find_set(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
}

void LimbFinder::branch(const WorkerBody& worker) {
    const auto nodes = static_cast<uint32_t>(centres_.size());
    falling_.clear();
    for (uint32_t n = 0; n < nodes; ++n)
        if (path_[n] != kUnreached) falling_.push_back(n);
    std::sort(falling_.begin(), falling_.end(),
              [this](uint32_t a, uint32_t b) { return path_[a] != path_[b] ? path_[a] > path_[b] : a < b; });
    std::sort(bridges_.begin(), bridges_.end());
    parent_.assign(nodes, kNone);
    peak_.assign(nodes, kNone);
    base_.assign(nodes, kNone);
    const auto shortest = static_cast<float>(params_.min_length_m);
    const auto merge = [&](uint32_t node, uint32_t other) {
        if (parent_[other] == kNone) return;
        uint32_t a = find_set(node), b = find_set(other);
        if (a == b) return;
        if (path_[peak_[a]] < path_[peak_[b]] || (path_[peak_[a]] == path_[peak_[b]] && peak_[a] > peak_[b]))
            std::swap(a, b);
        if (path_[peak_[b]] - path_[node] >= shortest) {
            const uint32_t root = base_[b] == kNone ? node : base_[b];
            add_limb(peak_[b], root, worker);
            if (base_[a] == kNone) base_[a] = node;
        }
        parent_[b] = a;
    };
    for (const uint32_t node : falling_) {
        parent_[node] = node;
        peak_[node] = node;
        for (uint32_t k = first_neighbour_[node]; k < first_neighbour_[node + 1]; ++k)
            merge(node, neighbours_[k].node);
        for (auto b = std::lower_bound(bridges_.begin(), bridges_.end(), std::make_pair(node, 0U));
             b != bridges_.end() && b->first == node; ++b)
            merge(node, b->second);
    }
    for (const uint32_t node : falling_)
        if (find_set(node) == node && path_[peak_[node]] >= shortest)
            add_limb(peak_[node], base_[node] == kNone ? falling_.back() : base_[node], worker);
}

void LimbFinder::add_limb(uint32_t tip, uint32_t root, const WorkerBody& worker) {
    Limb limb;
    limb.tip = worker.voxels[tip];
    limb.root = worker.voxels[root];
    limb.length = path_[tip] - path_[root];
    const auto longest = static_cast<float>(params_.max_length_m);
    // A flood from the tip that stays beyond the root's path length and within c_max.
    visited_.assign(centres_.size(), 0);
    flood_.assign(1, tip);
    visited_[tip] = 1;
    for (size_t next = 0; next < flood_.size(); ++next) {
        const uint32_t node = flood_[next];
        const auto visit = [&](uint32_t n) {
            if (visited_[n] || path_[n] == kUnreached || path_[n] <= path_[root]) return;
            if ((centres_[n] - centres_[tip]).norm() >= longest) return;
            visited_[n] = 1;
            flood_.push_back(n);
        };
        for (uint32_t k = first_neighbour_[node]; k < first_neighbour_[node + 1]; ++k)
            visit(neighbours_[k].node);
        for (const auto& [from, to] : bridges_) {
            if (from == node) visit(to);
            if (to == node) visit(from);
        }
    }
    std::sort(flood_.begin(), flood_.end(),
              [this](uint32_t a, uint32_t b) { return path_[a] != path_[b] ? path_[a] > path_[b] : a < b; });
    for (const uint32_t n : flood_) {
        limb.voxels.push_back(worker.voxels[n]);
        limb.to_tip.push_back(path_[tip] - path_[n]);
    }
    limbs_.push_back(std::move(limb));
}

}  // namespace deixis
