// What the worker means: the pointing ray of a frame, and the mark that a held point becomes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace deixis {

/// The worker's own left and right.
enum class ArmSide { left, right };

/// "left" or "right".
const char* name_of(ArmSide side);

/// A point on the part's surface, part frame [m]; `normal` is unit and looks towards the worker.
struct PartSpot {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// The ray of an extended arm (eq. 5.3), world frame [m].
struct PointingRay {
    ArmSide arm = ArmSide::right;
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();     ///< fingertip
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< unit
    std::optional<PartSpot> hit;                          ///< where it meets the tracked part
    bool touch = false;                                   ///< the fingertip is at the surface of `hit`
};

/// One "defect here". Says nothing of records: the station gives it an id when it is committed.
struct Mark {
    int64_t timestamp_us = 0;  ///< the frameset that completed the dwell
    PartSpot spot;
    ArmSide arm = ArmSide::right;
    double confidence = 0;  ///< 0 to 1: share of dwell frames seen, times how tightly the spots lay
    bool touch = false;
};

}  // namespace deixis
