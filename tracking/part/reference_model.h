// The part as the tracker knows it: skin points with normals at two densities, descriptors, nearest-point
// grid.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/geometry/surface_mesh.h"
#include "tracking/part/descriptors.h"
#include "tracking/part/nearest_point_grid.h"
#include "tracking/part/outer_skin.h"

namespace deixis {

struct ReferenceModelParams {
    double fine_spacing = 0.010;       ///< distance of the points of ICP [m]
    double coarse_spacing = 0.030;     ///< distance of the points with descriptors [m]
    double descriptor_radius = 0.120;  ///< neighbourhood of a descriptor [m]
    double grid_cell = 0.010;          ///< of the nearest-point grid [m]
    double reach = 0.150;              ///< the grid answers to this distance from the part [m]
    InvalidSettings validate() const;
};

/// Built once a part (about a second for a bumper), then read only: any number of threads may use it. The
/// same mesh gives the same model on every run. Part frame, metres.
class ReferenceModel {
  public:
    /// Refuses a mesh without any visible surface, or so large that the grid would not fit (the spacing is
    /// widened before that), in one sentence.
    static Result<std::shared_ptr<const ReferenceModel>> build(const SurfaceMesh& mesh,
                                                               const ReferenceModelParams& params);

    /// Distance to the nearest skin point, clamped to `reach` [m]; within about 1 cm of the exact distance.
    /// Two table look-ups: for "take the part out" of a cloud or a volume.
    float distance_to_surface(const Eigen::Vector3f& p_part) const;

    const std::vector<SkinPoint>& fine() const { return fine_; }
    const std::vector<SkinPoint>& coarse() const { return coarse_; }
    const std::vector<Descriptor>& descriptors() const { return descriptors_; }  ///< one a coarse point
    const NearestPointGrid& outer_grid() const { return outer_grid_; }           ///< indices into fine()
    const NearestPointGrid& inner_grid() const { return inner_grid_; }           ///< indices into fine()
    const Eigen::Vector3d& centre() const { return centre_; }  ///< mean of the outer fine points
    double radius() const { return radius_; }  ///< of the ball about the centre that holds the skin [m]
    const MeshBounds& bounds() const { return bounds_; }
    const ReferenceModelParams& params() const { return params_; }

  private:
    ReferenceModel() = default;

    ReferenceModelParams params_;
    std::vector<SkinPoint> fine_, coarse_;
    std::vector<Descriptor> descriptors_;
    NearestPointGrid outer_grid_, inner_grid_;
    Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
    double radius_ = 0;
    MeshBounds bounds_{};
};

}  // namespace deixis
