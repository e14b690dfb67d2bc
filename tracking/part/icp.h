// Point-to-plane ICP of a cloud against the reference model.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tracking/geometry/rigid_transform.h"
#include "tracking/part/reference_model.h"

namespace deixis {

/// A point of the scene for ICP.
struct ScenePoint {
    Eigen::Vector3f position;  ///< world [m]
    Eigen::Vector3f to_eye;    ///< unit, world: towards the sensor that saw it
    float weight = 1;          ///< inverse variance, any common scale
};

struct IcpStep {
    double gate;     ///< pairs farther apart than this are left out [m]
    int iterations;  ///< at most
};

struct IcpResult {
    RigidTransform world_from_part;
    int pairs = 0;   ///< in the last iteration
    double rms = 0;  ///< point-to-plane, of the pairs of the last iteration [m]
    double weakest =
        0;  ///< smallest eigenvalue of the Hessian per unit weight; 1 = every pair holds the direction
    Eigen::Matrix<double, 6, 1> weakest_direction =
        Eigen::Matrix<double, 6, 1>::Zero();  ///< turn * radius, then shift
    bool converged = false;
};

/// Refines `guess` step by step. Each point is paired with the nearest reference point whose normal faces the
/// point's sensor (the outer skin before the inner), pairs are weighed down by Tukey's biweight of the plane
/// distance, and pairs that lie beside the model (farther along the plane than `beside` of the gate allows)
/// are left out. Directions whose eigenvalue is under 1e-4 are not moved along. Linearised about the part's
/// centre. The order of the points decides the rounding; no threads. Source: Chen & Medioni, 1992.
IcpResult register_points(const std::vector<ScenePoint>& points, const ReferenceModel& model,
                          const RigidTransform& guess, const std::vector<IcpStep>& steps);

}  // namespace deixis
