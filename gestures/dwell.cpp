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
    require_range(complaints, "gap_s", gap_s, 0, 1);
    require_range(complaints, "tip_radius_m", tip_radius_m, 0.005, 0.5);
    require_range(complaints, "drift_m", drift_m, 0.001, 0.5);
    require_range(complaints, "spot_radius_m", spot_radius_m, 0.005, 1);
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
    const bool missing = !ray || !ray->hit || !ray->origin.allFinite() || !ray->hit->position.allFinite();
    const int64_t last_sample = samples_.empty() ? timestamp_us : samples_.back().timestamp_us;
    if (timestamp_us - last_sample > to_us(params_.gap_s)) samples_.clear();
    if (missing) return std::nullopt;
    samples_.push_back(
        {timestamp_us, ray->origin, ray->hit->position, ray->hit->normal, ray->arm, ray->touch});

    const int64_t dwell = to_us(params_.dwell_s);
    // The window begins with the last sample that is a full dwell time old.
    while (samples_.size() > 1 && timestamp_us - samples_[1].timestamp_us >= dwell) samples_.pop_front();
    if (marked_tip_ || timestamp_us - samples_.front().timestamp_us < dwell) return std::nullopt;
    constexpr size_t kFewestSamples = 8;
    if (samples_.size() < kFewestSamples) return std::nullopt;
    find_medians();
    if (steady_share() < params_.steady_share || drift() > params_.drift_m) return std::nullopt;
    marked_tip_ = tip_median_;
    last_near_us_ = last_seen_us_ = timestamp_us;
    return make_mark(timestamp_us);
}

void DwellDetector::watch_leaving(int64_t timestamp_us, const std::optional<PointingRay>& ray) {
    if (!marked_tip_) return;
    if (ray) {
        last_seen_us_ = timestamp_us;
        if (!((ray->origin - *marked_tip_).norm() > params_.away_m)) last_near_us_ = timestamp_us;
    }
    const bool went_away =
        timestamp_us == last_seen_us_ && timestamp_us - last_near_us_ >= to_us(params_.away_s);
    const bool gone = timestamp_us - last_seen_us_ >= to_us(params_.gone_s);
    if (!went_away && !gone) return;
    marked_tip_.reset();
    samples_.clear();
}

void DwellDetector::find_medians() {
    const auto median = [this](auto value_of) {
        values_.clear();
        for (const Sample& s : samples_) values_.push_back(value_of(s));
        const auto middle = values_.begin() + static_cast<std::ptrdiff_t>(values_.size() / 2);
        std::nth_element(values_.begin(), middle, values_.end());
        return *middle;
    };
    for (int axis = 0; axis < 3; ++axis) {
        tip_median_[axis] = median([axis](const Sample& s) { return s.tip[axis]; });
        spot_median_[axis] = median([axis](const Sample& s) { return s.spot[axis]; });
    }
}

double DwellDetector::steady_share() const {
    const auto steady = std::count_if(samples_.begin(), samples_.end(), [this](const Sample& s) {
        return (s.tip - tip_median_).norm() <= params_.tip_radius_m &&
               (s.spot - spot_median_).norm() <= params_.spot_radius_m;
    });
    return static_cast<double>(steady) / static_cast<double>(samples_.size());
}

double DwellDetector::drift() const {
    const size_t quarter = std::max<size_t>(samples_.size() / 4, 1);
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), last = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < quarter; ++k) {
        first += samples_[k].tip;
        last += samples_[samples_.size() - 1 - k].tip;
    }
    return (last - first).norm() / static_cast<double>(quarter);
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
