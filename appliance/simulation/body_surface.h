// The worker's skin: a smooth closed mesh grown once around the rest skeleton, and moved with the bones.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "appliance/simulation/body_skeleton.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

/// Trunk, head, arms and legs are one smooth union of rounded cones and ellipsoids, each hand another (with a
/// finger that folds); meshed by surface nets (Gibson 1998). Linear blend skinning, four bones a vertex at
/// most.
class BodySurface {
  public:
    /// `cell` edge of the meshing grid of the trunk [m]; hands use a third of it.
    explicit BodySurface(const BodyDimensions& dimensions, double cell = 0.018);

    const SurfaceMesh& rest_mesh() const { return rest_; }

    /// Vertices for `places`, in the order of `rest_mesh`; buffer reused.
    void move(const BodyPlaces& places, std::vector<Eigen::Vector3f>& vertices) const;

  private:
    struct Weights {
        std::array<uint8_t, 4> bone{};
        std::array<float, 4> share{};
    };
    SurfaceMesh rest_;
    std::vector<Weights> weights_;
};

}  // namespace deixis
