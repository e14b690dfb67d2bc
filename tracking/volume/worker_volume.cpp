// Components of worker voxels, the person among them, and the memory of things.
#include "tracking/volume/worker_volume.h"

#include <algorithm>
#include <cmath>

namespace deixis {
namespace {

constexpr int32_t kIdle = -1;
constexpr int32_t kActive = -2;
constexpr float kStandsOnFloor = 0.4F;  // a thing reaches below this [m]
constexpr float kForgetting = 0.5F;     // seconds of clutter lost in a second of being seen free
constexpr int kBlock = 6;  // voxels; nothing is learned in a person's block and its 26 neighbours
constexpr float kPersonRemembered = 1.0F;  // a person lost for less than this is still about [s]
constexpr float kHeadSlab = 0.25F;         // [m]
constexpr float kHeadSpan = 0.75F;         // widest top slab of a person, an arm beside the head included [m]

/// Calls `visit(neighbour index)` for the up to 26 neighbours inside the lattice.
template <class Visit>
void for_neighbours(const VoxelLattice& lattice, size_t index, int reach, Visit visit) {
    const Eigen::Vector3i c = lattice.coordinates(index);
    for (int z = std::max(c.z() - reach, 0); z <= std::min(c.z() + reach, lattice.nz - 1); ++z)
        for (int y = std::max(c.y() - reach, 0); y <= std::min(c.y() + reach, lattice.ny - 1); ++y)
            for (int x = std::max(c.x() - reach, 0); x <= std::min(c.x() + reach, lattice.nx - 1); ++x) {
                const size_t n = lattice.index(x, y, z);
                if (n != index) visit(n);
            }
}

template <class Visit>
void for_face_neighbours(const VoxelLattice& lattice, size_t index, Visit visit) {
    const Eigen::Vector3i c = lattice.coordinates(index);
    const size_t row = lattice.nx, plane = row * lattice.ny;
    if (c.x() > 0) visit(index - 1);
    if (c.x() + 1 < lattice.nx) visit(index + 1);
    if (c.y() > 0) visit(index - row);
    if (c.y() + 1 < lattice.ny) visit(index + row);
    if (c.z() > 0) visit(index - plane);
    if (c.z() + 1 < lattice.nz) visit(index + plane);
}

}  // namespace

InvalidSettings WorkerVolume::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "min_points", min_points, 1, 100);
    require_range(complaints, "outvoting_points", outvoting_points, 1, 1000);
    require_range(complaints, "min_voxels", min_voxels, 1, 100000);
    require_range(complaints, "min_height_m", min_height_m, 0.3, 2.0);
    require_range(complaints, "max_height_m", max_height_m, min_height_m, 3.0);
    require_range(complaints, "attach_m", attach_m, 0, 0.5);
    require_range(complaints, "clutter_s", clutter_s, 0.05, 60);
    return complaints;
}

WorkerVolume::WorkerVolume(Params params) : params_(params) {}

void WorkerVolume::start_afresh(const VoxelGrid& grid) {
    const size_t voxels = grid.states.size();
    own_points_.assign(voxels, 0);
    part_voxels_.assign(voxels, 0);
    labels_.assign(voxels, kIdle);
    clutter_s_.assign(voxels, 0);
    clutter_voxels_.clear();
    person_seen_s_ = kPersonRemembered;
    touched_.clear();
    body_ = WorkerBody{};
    started_ = false;
}

const WorkerBody& WorkerVolume::update(int64_t timestamp_us, const VoxelGrid& grid,
                                       const SurfacePoints& points, std::span<const uint8_t> part_points) {
    if (labels_.size() != grid.states.size() || (started_ && timestamp_us < last_us_)) start_afresh(grid);
    const double seconds = started_ ? static_cast<double>(timestamp_us - last_us_) * 1e-6 : 0.0;
    last_us_ = timestamp_us;
    started_ = true;
    body_.lattice = grid.lattice;

    gather(grid, points, part_points);
    label(grid.lattice);
    const int person = choose_person(grid.lattice);
    if (person >= 0) attach(grid.lattice, person);
    const auto step = static_cast<float>(std::min(seconds, 0.2));
    mark_person_blocks(grid.lattice, step);
    remember_clutter(grid, step);

    body_.present = person >= 0;
    collect(points);
    if (body_.present) measure(points);
    return body_;
}

void WorkerVolume::gather(const VoxelGrid& grid, const SurfacePoints& points,
                          std::span<const uint8_t> part_points) {
    for (const uint32_t v : touched_) {
        own_points_[v] = 0;
        part_voxels_[v] = 0;
        labels_[v] = kIdle;
    }
    touched_.clear();
    active_.clear();
    const bool part_known = part_points.size() == points.size();
    point_voxels_.assign(points.size(), -1);
    for (size_t i = 0; i < points.size(); ++i) {
        const bool of_part = part_known && part_points[i] != 0;
        if (!of_part && !points.foreground[i]) continue;
        const int64_t v = grid.lattice.find(points.positions[i]);
        if (v < 0) continue;
        auto& counter = of_part ? part_voxels_[v] : own_points_[v];
        if (own_points_[v] == 0 && part_voxels_[v] == 0) touched_.push_back(static_cast<uint32_t>(v));
        counter = static_cast<uint16_t>(std::min(counter + 1, 65535));
        if (!of_part) point_voxels_[i] = v;
    }
    const size_t with_points = touched_.size();
    const auto is_clutter = [&](size_t v) { return clutter_s_[v] >= static_cast<float>(params_.clutter_s); };
    for (size_t k = 0; k < with_points; ++k) {
        const uint32_t v = touched_[k];
        // Carving looks at the centre only: the rim of a thin arm can be seen past. Many points outvote it.
        const int needed = grid.state(v) == VoxelState::free ? params_.outvoting_points : params_.min_points;
        if (own_points_[v] < needed || own_points_[v] < part_voxels_[v] || is_clutter(v)) continue;
        labels_[v] = kActive;
        active_.push_back(v);
    }
    // One ring of occupied voxels around closes what noise tears; never into the part.
    const size_t seen = active_.size();
    for (size_t k = 0; k < seen; ++k)
        for_face_neighbours(grid.lattice, active_[k], [&](size_t n) {
            if (labels_[n] != kIdle || part_voxels_[n] > 0 || is_clutter(n)) return;
            if (grid.state(n) != VoxelState::occupied) return;
            if (own_points_[n] == 0) touched_.push_back(static_cast<uint32_t>(n));
            labels_[n] = kActive;
            active_.push_back(static_cast<uint32_t>(n));
        });
    std::sort(active_.begin(), active_.end());
}

void WorkerVolume::label(const VoxelLattice& lattice) {
    components_.clear();
    order_.clear();
    for (const uint32_t seed : active_) {
        if (labels_[seed] != kActive) continue;
        const auto id = static_cast<int32_t>(components_.size());
        Component& component = components_.emplace_back();
        component.first = order_.size();
        component.min = component.max = lattice.centre(seed);
        labels_[seed] = id;
        order_.push_back(seed);
        for (size_t next = component.first; next < order_.size(); ++next) {
            const Eigen::Vector3f centre = lattice.centre(order_[next]);
            component.min = component.min.cwiseMin(centre);
            component.max = component.max.cwiseMax(centre);
            for_neighbours(lattice, order_[next], 1, [&](size_t n) {
                if (part_voxels_[n] > 0) component.at_part = true;
                if (labels_[n] != kActive) return;
                labels_[n] = id;
                order_.push_back(static_cast<uint32_t>(n));
            });
        }
        component.count = order_.size() - component.first;
    }
}

bool WorkerVolume::is_upright(const VoxelLattice& lattice, const Component& component) const {
    const float top = component.max.z();
    if (component.count < static_cast<size_t>(params_.min_voxels)) return false;
    if (top < params_.min_height_m || top > params_.max_height_m) return false;
    if (top - component.min.z() < 0.4F * top) return false;
    Eigen::Vector3f low = component.max, high = component.min;
    for (size_t k = component.first; k < component.first + component.count; ++k) {
        const Eigen::Vector3f c = lattice.centre(order_[k]);
        if (c.z() < top - kHeadSlab) continue;
        low = low.cwiseMin(c);
        high = high.cwiseMax(c);
    }
    return (high - low).head<2>().maxCoeff() < kHeadSpan;
}

int WorkerVolume::choose_person(const VoxelLattice& lattice) const {
    int best = -1;
    double best_score = 0;
    for (size_t c = 0; c < components_.size(); ++c) {
        const Component& component = components_[c];
        if (!is_upright(lattice, component)) continue;
        double score = static_cast<double>(component.count);
        const Eigen::Vector3f middle = (component.min + component.max) / 2;
        if (body_.present && (middle - body_.middle).head<2>().norm() < 0.6F) score *= 4;
        if (best < 0 || score > best_score) {
            best = static_cast<int>(c);
            best_score = score;
        }
    }
    return best;
}

void WorkerVolume::attach(const VoxelLattice& lattice, int person) {
    components_[person].of_worker = true;
    for (Component& component : components_) {
        if (component.of_worker || component.min.z() < kStandsOnFloor) continue;
        // At the part it may be a hand, or what holds the part: the hand's arm ends close by.
        const double gap = component.at_part ? params_.attach_m / 2 : params_.attach_m;
        const int reach = static_cast<int>(std::ceil(gap / lattice.side));
        if (component.count > components_[person].count / 3) continue;
        for (size_t k = component.first; k < component.first + component.count && !component.of_worker; ++k)
            for_neighbours(lattice, order_[k], reach, [&](size_t n) {
                if (labels_[n] == person) component.of_worker = true;
            });
    }
}

void WorkerVolume::mark_person_blocks(const VoxelLattice& lattice, float seconds) {
    person_seen_s_ += seconds;
    const bool present =
        std::any_of(components_.begin(), components_.end(), [](const Component& c) { return c.of_worker; });
    if (!present && person_seen_s_ <= kPersonRemembered) return;
    blocks_ = {lattice.nx / kBlock + 1, lattice.ny / kBlock + 1, lattice.nz / kBlock + 1};
    near_person_.assign(static_cast<size_t>(blocks_.prod()), 0);
    if (!present) return;
    person_seen_s_ = 0;
    for (const Component& component : components_) {
        if (!component.of_worker) continue;
        for (size_t k = component.first; k < component.first + component.count; ++k) {
            const Eigen::Vector3i block = lattice.coordinates(order_[k]) / kBlock;
            for (int z = std::max(block.z() - 1, 0); z <= std::min(block.z() + 1, blocks_.z() - 1); ++z)
                for (int y = std::max(block.y() - 1, 0); y <= std::min(block.y() + 1, blocks_.y() - 1); ++y)
                    for (int x = std::max(block.x() - 1, 0); x <= std::min(block.x() + 1, blocks_.x() - 1);
                         ++x)
                        near_person_[(static_cast<size_t>(z) * blocks_.y() + y) * blocks_.x() + x] = 1;
        }
    }
}

bool WorkerVolume::is_near_person(const VoxelLattice& lattice, size_t voxel) const {
    const Eigen::Vector3i block = lattice.coordinates(voxel) / kBlock;
    return near_person_[(static_cast<size_t>(block.z()) * blocks_.y() + block.y()) * blocks_.x() +
                        block.x()] != 0;
}

void WorkerVolume::remember_clutter(const VoxelGrid& grid, float seconds) {
    const auto longest = static_cast<float>(4 * params_.clutter_s);
    size_t kept = 0;
    for (const uint32_t v : clutter_voxels_) {
        // A thin bar is seen past and yet seen: as long as points lie in it, it is there.
        if (own_points_[v] >= params_.min_points)
            clutter_s_[v] = std::min(clutter_s_[v] + seconds, longest);
        else if (grid.state(v) == VoxelState::free)
            clutter_s_[v] -= kForgetting * seconds;
        if (clutter_s_[v] <= 0) {
            clutter_s_[v] = 0;
            continue;
        }
        clutter_voxels_[kept++] = v;
    }
    clutter_voxels_.resize(kept);
    if (seconds <= 0) return;
    const auto grow = [&](size_t v) {
        // A forearm behind an edge, or one that noise has cut off, is no thing.
        if (is_near_person(grid.lattice, v)) return;
        if (clutter_s_[v] == 0) clutter_voxels_.push_back(static_cast<uint32_t>(v));
        clutter_s_[v] = std::min(clutter_s_[v] + seconds, longest);
    };
    for (const Component& component : components_) {
        if (component.of_worker) continue;
        for (size_t k = component.first; k < component.first + component.count; ++k) {
            grow(order_[k]);
            // Its surface flickers by a voxel from frame to frame.
            for_face_neighbours(grid.lattice, order_[k], [&](size_t n) {
                if (labels_[n] < 0) grow(n);
            });
        }
    }
}

std::vector<uint32_t> WorkerVolume::clutter() const {
    std::vector<uint32_t> things;
    for (const uint32_t v : clutter_voxels_)
        if (clutter_s_[v] >= params_.clutter_s) things.push_back(v);
    std::sort(things.begin(), things.end());
    return things;
}

void WorkerVolume::collect(const SurfacePoints& points) {
    body_.voxels.clear();
    body_.points.clear();
    if (!body_.present) return;
    for (const uint32_t v : active_)
        if (components_[labels_[v]].of_worker) body_.voxels.push_back(v);
    for (size_t i = 0; i < points.size(); ++i) {
        const int64_t v = point_voxels_[i];
        if (v >= 0 && labels_[v] >= 0 && components_[labels_[v]].of_worker)
            body_.points.push_back(static_cast<uint32_t>(i));
    }
}

void WorkerVolume::measure(const SurfacePoints& points) {
    heights_.clear();
    for (const uint32_t i : body_.points) heights_.push_back(points.positions[i].z());
    if (heights_.size() < 50) {
        body_.present = false;
        body_.voxels.clear();
        body_.points.clear();
        return;
    }
    // The 20th highest point: above it is noise.
    std::nth_element(heights_.begin(), heights_.begin() + 20, heights_.end(), std::greater<>());
    const float top = heights_[20];
    Eigen::Vector3f head = Eigen::Vector3f::Zero(), trunk = Eigen::Vector3f::Zero();
    int head_points = 0, trunk_points = 0;
    for (const uint32_t i : body_.points) {
        const Eigen::Vector3f& p = points.positions[i];
        if (p.z() > top - 0.18F) head += p, ++head_points;
        if (p.z() > 0.55F * top && p.z() < 0.8F * top) trunk += p, ++trunk_points;
    }
    body_.head_top = head / static_cast<float>(head_points);
    body_.head_top.z() = top;
    body_.middle =
        trunk_points > 0 ? Eigen::Vector3f(trunk / static_cast<float>(trunk_points)) : body_.head_top;
    // Standing height: rises quickly with what is seen, falls slowly (he bends).
    if (body_.height == 0) body_.height = top;
    body_.height += (top > body_.height ? 0.1F : 0.001F) * (top - body_.height);
}

}  // namespace deixis
