// Arms: elongated clusters of worker voxels that reach out of the body (thesis 5.1.1). In: worker, part; out:
// arms.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "gestures/mark.h"
#include "tracking/geometry/result.h"
#include "tracking/volume/surface_points.h"
#include "tracking/volume/worker_volume.h"

namespace deixis {

/// An extended arm, world frame [m].
struct ArmCluster {
    ArmSide side = ArmSide::right;
    Eigen::Vector3d tip =
        Eigen::Vector3d::Zero();  ///< fingertip: end of the fitted axis among the surface points
    Eigen::Vector3d root = Eigen::Vector3d::Zero();  ///< where the arm leaves the body
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< unit, from the elbow towards the tip (eq. 5.3)
    Eigen::Vector3d eye = Eigen::Vector3d::Zero();   ///< between the eyes, from the head
    double length = 0;                               ///< along the voxels, tip to root [m]
    double width = 0;                                ///< twice the RMS distance from the axis [m]
    std::vector<uint32_t> points;  ///< of the forearm and hand, indices into the SurfacePoints
};

/// The direction of interaction: the cell's pointing axis or, without it, from the worker to the part.
struct InteractionAxis {
    Eigen::Vector3d direction = Eigen::Vector3d::UnitY();   ///< unit
    Eigen::Vector3d part_middle = Eigen::Vector3d::Zero();  ///< of the part's bounds, world frame [m]
};

}  // namespace deixis
