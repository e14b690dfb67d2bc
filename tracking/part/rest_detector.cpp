// A window of poses: still when all are near their mean.
#include "tracking/part/rest_detector.h"

#include <algorithm>

namespace deixis {
namespace {

constexpr size_t fewest_samples = 5;
constexpr int frames_away = 2;

}  // namespace

RestDetector::RestDetector(const Eigen::Vector3d& centre, double radius, RestParams params)
    : centre_(centre), radius_(radius), params_(params) {}

void RestDetector::reset() {
    samples_.clear();
    at_rest_ = false;
    away_ = off_ = 0;
}

double RestDetector::distance(const RigidTransform& a, const RigidTransform& b) const {
    return (a * centre_ - b * centre_).norm() + 0.5 * radius_ * rotation_between(a, b);
}

RigidTransform RestDetector::mean_of_samples(size_t from, size_t to) const {
    RigidTransform mean{Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero()};
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (size_t i = from; i < to; ++i) {
        mean.rotation += samples_[i].pose.rotation;
        place += samples_[i].pose * centre_;
    }
    mean.rotation = nearest_rotation(mean.rotation);
    mean.translation = place / static_cast<double>(to - from) - mean.rotation * centre_;
    return mean;
}

void RestDetector::settle(int64_t now_us) {
    const auto window_us = static_cast<int64_t>(params_.rest_s * 1e6);
    // The oldest sample is kept just outside the window, so that the window is known to be full.
    while (samples_.size() > 1 && now_us - samples_[1].timestamp_us >= window_us)
        samples_.erase(samples_.begin());
    if (samples_.size() < fewest_samples || now_us - samples_.front().timestamp_us < window_us) return;
    // Noise shakes single poses; motion shifts the second half against the first.
    const size_t half = samples_.size() / 2;
    if (distance(mean_of_samples(0, half), mean_of_samples(half, samples_.size())) > 0.5 * params_.rest_m)
        return;
    const RigidTransform mean = mean_of_samples(0, samples_.size());
    if (std::any_of(samples_.begin(), samples_.end(),
                    [&](const Sample& s) { return distance(s.pose, mean) > 2 * params_.rest_m; }))
        return;
    at_rest_ = true;
    away_ = off_ = 0;
    resting_ = mean;
    averaged_ = static_cast<int>(samples_.size());
    rotation_sum_ = mean.rotation * averaged_;
    centre_sum_ = (mean * centre_) * averaged_;
    samples_.clear();
}

void RestDetector::add(int64_t timestamp_us, const RigidTransform& world_from_part, bool certain) {
    if (!at_rest_) {
        if (!samples_.empty() && timestamp_us <= samples_.back().timestamp_us) return;
        samples_.push_back({timestamp_us, world_from_part});
        settle(timestamp_us);
        return;
    }
    const double off = distance(world_from_part, resting_);
    off_ = off > params_.rest_m ? off_ + 1 : 0;
    const bool leap = off > 2 * params_.motion_m;
    const bool away = off > params_.motion_m && (certain || leap);
    away_ = away ? away_ + 1 : 0;
    if (away_ >= frames_away || off > 4 * params_.motion_m) {
        reset();
        samples_.push_back({timestamp_us, world_from_part});
        return;
    }
    if (off_ > 0 || averaged_ >= params_.average) return;
    ++averaged_;
    rotation_sum_ += world_from_part.rotation;
    centre_sum_ += world_from_part * centre_;
    resting_.rotation = nearest_rotation(rotation_sum_);
    resting_.translation = centre_sum_ / averaged_ - resting_.rotation * centre_;
}

}  // namespace deixis
