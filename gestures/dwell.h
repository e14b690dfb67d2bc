// Dwell: a point held still long enough at a resting part is a mark, once. In: rays of one arm; out: marks.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "gestures/mark.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// Stillness is asked over the whole dwell time of the spot on the part and of the ray in the world: across
/// its direction closely, along it loosely, because a finger of few pixels comes and goes. Most frames have
/// to lie within a radius of the medians, and nothing may drift from the first to the last quarter (the slow
/// ends of reaching out and drawing back are no part of the hold). One mark a hold: after it the arm has to
/// go away before the next. Motion or loss of the part, a gap, and stamps that jump back begin a new dwell.
/// Deterministic.
class DwellDetector {
  public:
    struct Params {
        double dwell_s = 1.0;       ///< hold that makes a mark [s]
        double slow_ends_s = 0.15;  ///< of reaching out and drawing back, as still as a hold; added to it [s]
        double gap_s = 0.2;         ///< longest run of missing frames inside a hold [s]
        double across_radius_m = 0.035;  ///< of the fingertip around its median, across the ray [m]
        double across_drift_m = 0.012;   ///< of the fingertip at either end of the hold, across the ray [m]
        double along_drift_m = 0.04;     ///< from the first to the last quarter, along the ray [m]
        double spot_radius_m = 0.10;     ///< of the spot around its median [m]
        double spot_drift_m = 0.05;      ///< of the spot at either end of the hold [m]
        double steady_share = 0.8;       ///< of the frames in the dwell time that have to be within the radii
        double away_m = 0.12;            ///< a ray this far from a marked hold has left it [m]
        double away_s = 0.3;             ///< when it is there for this long [s]
        double gone_s = 0.8;             ///< or when no arm points for this long [s]

        InvalidSettings validate() const;
    };

    explicit DwellDetector(Params params);

    /// One call a frameset; `ray` is null when the arm does not point, and counts as missing without a hit.
    /// The spot of a mark is the median, coordinate by coordinate, of the spots held.
    std::optional<Mark> update(int64_t timestamp_us, const std::optional<PointingRay>& ray,
                               bool part_tracked_and_at_rest);

  private:
    struct Sample {
        int64_t timestamp_us = 0;
        Eigen::Vector3d tip, direction, spot, normal;
        ArmSide arm = ArmSide::right;
        bool touch = false;
    };

    bool is_away(const PointingRay& ray) const;
    void watch_leaving(int64_t timestamp_us, const std::optional<PointingRay>& ray);
    void find_medians();
    double across(const Sample& sample) const;
    double steady_share() const;
    bool drifts();
    Mark make_mark(int64_t timestamp_us) const;

    /// The value that `share` of the samples [first, last) lie below.
    template <class Value>
    double quantile(size_t first, size_t last, double share, Value value_of);

    Params params_;
    std::deque<Sample> samples_;
    std::optional<Eigen::Vector3d> marked_tip_;
    int64_t last_us_ = 0, last_near_us_ = 0, last_seen_us_ = 0;
    bool started_ = false;
    Eigen::Vector3d tip_median_ = Eigen::Vector3d::Zero(), spot_median_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d direction_median_ = Eigen::Vector3d::UnitY();
    std::vector<double> values_;
};

}  // namespace deixis
