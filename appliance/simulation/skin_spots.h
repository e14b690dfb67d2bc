// Spots on the outer skin of a part that a worker can point at: drawn by area, or checked when given.
#pragma once

#include <optional>
#include <vector>

#include "appliance/simulation/counter_random.h"
#include "tracking/geometry/ray_caster.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

struct SkinSpot {
    Eigen::Vector3d position;  ///< part frame [m]
    Eigen::Vector3d normal;    ///< unit, outwards to the worker
};

/// All of one part; `mesh` and `caster` (which holds it as its only mesh) must outlive it.
class SkinSpots {
  public:
    /// `towards_worker`: unit, part frame.
    SkinSpots(const SurfaceMesh& mesh, const RayCaster& caster, const Eigen::Vector3d& towards_worker);

    /// A spot with even density over the skin that faces the worker (within 60 degrees), 4 cm clear of edges
    /// and holes; nothing when many tries found none.
    std::optional<SkinSpot> draw(DrawSequence& draw) const;

    /// The spot of the outer skin nearest to `position`, when it lies within 5 mm.
    std::optional<SkinSpot> at(const Eigen::Vector3d& position) const;

    /// Largest extent of the skin along `towards_worker` cross up: half the part's width [m].
    double half_width() const { return half_width_; }
    const Eigen::Vector3d& middle() const { return middle_; }

  private:
    std::optional<SkinSpot> seen_at(const Eigen::Vector3d& position, const Eigen::Vector3d& normal) const;

    const SurfaceMesh& mesh_;
    const RayCaster& caster_;
    Eigen::Vector3d towards_worker_;
    Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
    double half_width_ = 0;
    std::vector<uint32_t> facing_;     ///< triangles that face the worker
    std::vector<double> area_before_;  ///< running sum of their areas
};

}  // namespace deixis
