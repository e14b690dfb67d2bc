// The pointing ray and the spot it means on the part (thesis eq. 5.3). In: arm points, CAD surface; out: ray,
// spot.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "gestures/mark.h"
#include "tracking/geometry/ray_caster.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/rigid_transform.h"

namespace deixis {

struct FittedLine {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit, positive along the main axis
};

/// Double linear regression, eq. 5.3 with any unit `main_axis` in the place of y: the two coordinates across
/// it are regressed on the one along it. `weights` >= 0, as many as points. Nothing when the points (fewer
/// than two, or all at one place along the axis) do not say a direction, or are not finite.
std::optional<FittedLine> fit_along(std::span<const Eigen::Vector3d> points, std::span<const double> weights,
                                    const Eigen::Vector3d& main_axis);

struct PointingParams {
    double eye_weight = 0.30;           ///< 0 = along the forearm, 1 = from the eye through the fingertip
    double max_reach_m = 1.2;           ///< a hit farther than this from the fingertip is none [m]
    double touch_m = 0.05;              ///< a surface nearer than this before the fingertip is touched [m]
    double snap_m = 0.06;               ///< a ray passing this near to the part means its nearest spot [m]
    double tip_sigma_m = 0.03;          ///< of the fingertip, across the ray [m]
    double direction_sigma_deg = 11.5;  ///< of the ray's direction [degrees]; 0: the ray's own cut alone
    double closeness_m = 0.06;          ///< scale of the gap that workers leave before what they mean [m]

    InvalidSettings validate() const;
};

/// Unit direction between forearm and eye-to-fingertip, weighted by `eye_weight`.
Eigen::Vector3d blend_directions(const Eigen::Vector3d& forearm, const Eigen::Vector3d& eye,
                                 const Eigen::Vector3d& tip, double eye_weight);

struct MeantSpot {
    PartSpot spot;          ///< part frame
    double distance_m = 0;  ///< from the fingertip
    bool touch = false;
    bool snapped = false;  ///< the ray itself missed
};

/// The spot that a ray of the world frame means. Neither fingertip nor direction are known exactly, and on a
/// surface that runs nearly along the ray a degree is a decimetre. So a ray that meets the part gives the
/// mean over all spots in a cone of two standard deviations, each weighed by how well the ray explains it and
/// by the prior that fingers come close to what they mean; a near miss gives the surface point nearest to the
/// ray.
std::optional<MeantSpot> spot_on_part(const RayCaster& surface, const RigidTransform& world_from_part,
                                      const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                      const PointingParams& params);

}  // namespace deixis
