// Arms: limbs that reach out of the trunk and are longer than wide (thesis 5.1.1). In: worker; out: axis,
// tip, side.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gestures/limbs.h"
#include "gestures/mark.h"
#include "gestures/pointing.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/volume/surface_points.h"
#include "tracking/volume/worker_volume.h"

namespace deixis {

/// An extended arm, world frame [m].
struct ArmCluster {
    ArmSide side = ArmSide::right;
    Eigen::Vector3d tip =
        Eigen::Vector3d::Zero();  ///< fingertip: end of the fitted axis among the surface points
    Eigen::Vector3d root = Eigen::Vector3d::Zero();  ///< where the arm leaves the body
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< unit, along forearm and hand to the tip (eq. 5.3)
    Eigen::Vector3d eye = Eigen::Vector3d::Zero();   ///< between the eyes, from head and height
    double length = 0;                               ///< path from root to tip [m]
    double width = 0;                                ///< twice the RMS distance from the axis [m]
};

/// Finds the arms that point somewhere: limbs whose end is well off the trunk, whose forearm is a thin
/// straight piece, and which do not hang down. Deterministic.
class ArmFinder {
  public:
    struct Params {
        double min_length_m = 0.28;       ///< of the limb [m]
        double forearm_of_height = 0.17;  ///< fitted piece from the fingertip, share of the standing height
        double max_width_m = 0.16;        ///< of the fitted piece [m]
        double min_off_trunk_m = 0.25;    ///< fingertip from the middle of the body, horizontally [m]
        double min_tip_height_m = 0.25;   ///< above the floor: below it are feet [m]
        double steepest_down = 0.95;      ///< sine of the steepest way down of the axis
        double eye_of_height = 0.065;     ///< eyes under the top of the skull, share of the standing height

        InvalidSettings validate() const;
    };

    /// The sensors say from where each surface point was seen: only the near side of an arm is seen.
    ArmFinder(const std::vector<CalibratedSensor>& depth_sensors, Params params);

    /// `part_points` as given to WorkerVolume. `forward` is the horizontal unit direction that the worker
    /// faces, from him to the part; his left and right follow from it. At most two arms, longest first.
    const std::vector<ArmCluster>& update(const WorkerBody& worker, const SurfacePoints& points,
                                          std::span<const uint8_t> part_points,
                                          const std::vector<Limb>& limbs, const Eigen::Vector3d& forward);

    const std::vector<ArmCluster>& arms() const { return arms_; }
    void clear() { arms_.clear(); }

  private:
    /// Of one sensor and one slice across the arm.
    struct SliceSum {
        int count = 0;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        double sideways = 0, sideways2 = 0;
    };

    std::optional<ArmCluster> examine(const Limb& limb, const WorkerBody& worker, const SurfacePoints& points,
                                      std::span<const uint8_t> part_points, const Eigen::Vector3d& forward);
    std::optional<FittedLine> fit(const Limb& limb, const WorkerBody& worker, const SurfacePoints& points);
    std::optional<FittedLine> regress(const FittedLine& line, const SurfacePoints& points);
    double width_around(const FittedLine& line, const SurfacePoints& points) const;
    Eigen::Vector3d find_tip(const FittedLine& line, const SurfacePoints& points,
                             std::span<const uint8_t> part_points);
    Eigen::Vector3d head_centre(const WorkerBody& worker, const SurfacePoints& points) const;

    Params params_;
    std::vector<Eigen::Vector3d> places_;  ///< of the sensors
    std::vector<ArmCluster> arms_;
    std::vector<uint8_t> in_limb_;  ///< by voxel
    std::vector<uint32_t> limb_points_;
    std::vector<SliceSum> slices_;          ///< slice by slice, a sensor each
    std::vector<Eigen::Vector3d> centres_;  ///< of the slices, inside the arm
    std::vector<double> weights_;
    std::vector<float> along_;
    Eigen::Vector3d head_ = Eigen::Vector3d::Zero();
};

}  // namespace deixis
