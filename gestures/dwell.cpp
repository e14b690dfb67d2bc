// The dwell window and the memory of the last mark.
#include "gestures/dwell.h"

#include <algorithm>
#include <cmath>

namespace deixis {
namespace {

int64_t to_us(double seconds) {
    return std::llround(seconds * 1e6);
}

}  // namespace

InvalidSettings DwellDetector::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "dwell_s", dwell_s, 0.2, 10);
    require_range(complaints, "slow_ends_s", slow_ends_s, 0, 1);
    require_range(complaints, "gap_s", gap_s, 0, 1);
    require_range(complaints, "across_radius_m", across_radius_m, 0.005, 0.5);
    require_range(complaints, "across_drift_m", across_drift_m, 0.001, 0.5);
    require_range(complaints, "along_drift_m", along_drift_m, 0.001, 0.5);
    require_range(complaints, "spot_radius_m", spot_radius_m, 0.005, 1);
    require_range(complaints, "spot_drift_m", spot_drift_m, 0.001, 1);
    require_range(complaints, "steady_share", steady_share, 0.1, 1);
    require_range(complaints, "away_m", away_m, 0.01, 1);
    require_range(complaints, "away_s", away_s, 0, 10);
    require_range(complaints, "gone_s", gone_s, 0, 10);
    return complaints;
}

DwellDetector::DwellDetector(Params params) : params_(params) {}

std::optional<Mark> DwellDetector::update(int64_t timestamp_us, const std::optional<PointingRay>& ray,
                                          bool part_tracked_and_at_rest) {
    if (started_ && timestamp_us <= last_us_) {
        samples_.clear();
        marked_tip_.reset();
    }
    started_ = true;
    last_us_ = timestamp_us;
    watch_leaving(timestamp_us, ray);
    if (!part_tracked_and_at_rest) {
        samples_.clear();
        return std::nullopt;
    }
    const bool missing = !ray || !ray->hit || !ray->origin.allFinite() || !ray->direction.allFinite() ||
                         !ray->hit->position.allFinite();
    const int64_t last_sample = samples_.empty() ? timestamp_us : samples_.back().timestamp_us;
    if (timestamp_us - last_sample > to_us(params_.gap_s)) samples_.clear();
    if (missing) return std::nullopt;
    samples_.push_back({timestamp_us, ray->origin, ray->direction, ray->hit->position, ray->hit->normal,
                        ray->arm, ray->touch});

    const int64_t dwell = to_us(params_.dwell_s + params_.slow_ends_s);
    // The window begins with the last sample that is a full dwell time old.
    while (samples_.size() > 1 && timestamp_us - samples_[1].timestamp_us >= dwell) samples_.pop_front();
    if (marked_tip_ || timestamp_us - samples_.front().timestamp_us < dwell) return std::nullopt;
    constexpr size_t kFewestSamples = 8;
    if (samples_.size() < kFewestSamples) return std::nullopt;
    find_medians();
    if (steady_share() < params_.steady_share || drifts()) return std::nullopt;
    marked_tip_ = tip_median_;
    last_near_us_ = last_seen_us_ = timestamp_us;
    return make_mark(timestamp_us);
}

/// The marked place is off the line of the ray, or far before or behind its fingertip.
bool DwellDetector::is_away(const PointingRay& ray) const {
    constexpr double kAlong = 0.3;  // [m]
    const Eigen::Vector3d from = *marked_tip_ - ray.origin;
    const double along = from.dot(ray.direction);
    return !(std::abs(along) < kAlong && (from - along * ray.direction).norm() < params_.away_m);
}

void DwellDetector::watch_leaving(int64_t timestamp_us, const std::optional<PointingRay>& ray) {
    if (!marked_tip_) return;
    if (ray) {
        last_seen_us_ = timestamp_us;
        if (!is_away(*ray)) last_near_us_ = timestamp_us;
    }
    const bool went_away =
        timestamp_us == last_seen_us_ && timestamp_us - last_near_us_ >= to_us(params_.away_s);
    const bool gone = timestamp_us - last_seen_us_ >= to_us(params_.gone_s);
    if (!went_away && !gone) return;
    marked_tip_.reset();
    samples_.clear();
}

template <class Value>
double DwellDetector::quantile(size_t first, size_t last, double share, Value value_of) {
    values_.clear();
    for (size_t k = first; k < last; ++k) values_.push_back(value_of(samples_[k]));
    const auto rank = std::lround(share * static_cast<double>(values_.size() - 1));
    std::nth_element(values_.begin(), values_.begin() + rank, values_.end());
    return values_[static_cast<size_t>(rank)];
}

void DwellDetector::find_medians() {
    for (int axis = 0; axis < 3; ++axis) {
        const size_t all = samples_.size();
        tip_median_[axis] = quantile(0, all, 0.5, [axis](const Sample& s) { return s.tip[axis]; });
        spot_median_[axis] = quantile(0, all, 0.5, [axis](const Sample& s) { return s.spot[axis]; });
        direction_median_[axis] =
            quantile(0, all, 0.5, [axis](const Sample& s) { return s.direction[axis]; });
    }
    if (direction_median_.norm() > 1e-6) direction_median_.normalize();
}

double DwellDetector::across(const Sample& sample) const {
    const Eigen::Vector3d off = sample.tip - tip_median_;
    return (off - off.dot(direction_median_) * direction_median_).norm();
}

double DwellDetector::steady_share() const {
    const auto steady = std::count_if(samples_.begin(), samples_.end(), [this](const Sample& s) {
        return across(s) <= params_.across_radius_m &&
               (s.spot - spot_median_).norm() <= params_.spot_radius_m;
    });
    return static_cast<double>(steady) / static_cast<double>(samples_.size());
}

/// The first and the last moments against the middle half: both ends of a short hold are on the move.
bool DwellDetector::drifts() {
    const size_t all = samples_.size(), middle_first = all / 4, middle_last = all - all / 4;
    const size_t end = std::max<size_t>(all / 10, 2);
    const auto off_middle = [&](auto vector_of) {
        Eigen::Vector3d middle, first = Eigen::Vector3d::Zero(), last = Eigen::Vector3d::Zero();
        for (int axis = 0; axis < 3; ++axis)
            middle[axis] =
                quantile(middle_first, middle_last, 0.5, [&](const Sample& s) { return vector_of(s)[axis]; });
        for (size_t k = 0; k < end; ++k) {
            first += vector_of(samples_[k]) - middle;
            last += vector_of(samples_[all - 1 - k]) - middle;
        }
        return std::max(first.norm(), last.norm()) / static_cast<double>(end);
    };
    const double across = off_middle([this](const Sample& s) {
        const Eigen::Vector3d off = s.tip - tip_median_;
        return Eigen::Vector3d(off - off.dot(direction_median_) * direction_median_);
    });
    const double spot = off_middle([](const Sample& s) { return s.spot; });
    // Along the ray the fingertip is sometimes missed, never invented: the upper end counts.
    constexpr double kUpper = 0.8;
    const auto along_of = [this](const Sample& s) { return (s.tip - tip_median_).dot(direction_median_); };
    const size_t quarter = std::max<size_t>(all / 4, 2);
    const double along =
        quantile(all - quarter, all, kUpper, along_of) - quantile(0, quarter, kUpper, along_of);
    return across > params_.across_drift_m || std::abs(along) > params_.along_drift_m ||
           spot > params_.spot_drift_m;
}

Mark DwellDetector::make_mark(int64_t timestamp_us) const {
    Mark mark;
    mark.timestamp_us = timestamp_us;
    mark.spot.position = spot_median_;
    double spread = 0;
    size_t right = 0, touching = 0;
    const Sample* nearest = &samples_.front();
    for (const Sample& s : samples_) {
        spread += (s.spot - spot_median_).norm() / static_cast<double>(samples_.size());
        right += s.arm == ArmSide::right;
        touching += s.touch;
        if ((s.spot - spot_median_).norm() < (nearest->spot - spot_median_).norm()) nearest = &s;
    }
    mark.spot.normal = nearest->normal;
    mark.arm = 2 * right >= samples_.size() ? ArmSide::right : ArmSide::left;
    mark.touch = 2 * touching > samples_.size();
    mark.confidence = steady_share() * std::exp(-spread / params_.spot_radius_m);
    return mark;
}

}  // namespace deixis
