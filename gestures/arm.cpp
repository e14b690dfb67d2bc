// Forearm axis from the surface points of a limb, fingertip, side; what is no pointing arm is dropped.
#include "gestures/arm.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace deixis {
namespace {

constexpr double kSliceLength = 0.03;  // [m]
constexpr size_t kSlices = 32;         // around the middle of the piece
constexpr int kFewestInSlice = 4;
constexpr double kThickestRadius = 0.07;  // of a forearm in a sleeve [m]
constexpr float kTipReach = 0.05F;        // points this near to the axis can be the finger [m]
constexpr float kTipGap = 0.05F;          // a longer gap along the axis ends the hand [m]
constexpr size_t kTipRank = 6;            // the points beyond the fingertip are noise
constexpr double kHeadShell = 0.05;       // from the seen side of a head to its middle [m]

Eigen::Vector3d mean_of_voxels(const Limb& limb, const VoxelLattice& lattice, double from, double to) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (size_t k = 0; k < limb.voxels.size(); ++k) {
        if (limb.to_tip[k] < from || limb.to_tip[k] > to) continue;
        sum += lattice.centre(limb.voxels[k]).cast<double>();
        ++count;
    }
    return count > 0 ? Eigen::Vector3d(sum / count) : lattice.centre(limb.tip).cast<double>();
}

}  // namespace

InvalidSettings ArmFinder::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "min_length_m", min_length_m, 0.05, 1.0);
    require_range(complaints, "forearm_of_height", forearm_of_height, 0.05, 0.5);
    require_range(complaints, "max_width_m", max_width_m, 0.02, 1.0);
    require_range(complaints, "min_off_trunk_m", min_off_trunk_m, 0, 1.0);
    require_range(complaints, "min_tip_height_m", min_tip_height_m, 0, 2.0);
    require_range(complaints, "steepest_down", steepest_down, 0, 1);
    require_range(complaints, "eye_of_height", eye_of_height, 0, 0.2);
    return complaints;
}

ArmFinder::ArmFinder(const std::vector<CalibratedSensor>& depth_sensors, Params params) : params_(params) {
    for (const CalibratedSensor& sensor : depth_sensors)
        places_.push_back(sensor.camera_from_world.inverse().translation);
}

const std::vector<ArmCluster>& ArmFinder::update(const WorkerBody& worker, const SurfacePoints& points,
                                                 std::span<const uint8_t> part_points,
                                                 const std::vector<Limb>& limbs,
                                                 const Eigen::Vector3d& forward) {
    arms_.clear();
    if (!worker.present) return arms_;
    if (in_limb_.size() != worker.lattice.size()) in_limb_.assign(worker.lattice.size(), 0);
    head_ = head_centre(worker, points);
    constexpr size_t kArms = 2;
    for (const Limb& limb : limbs) {
        if (arms_.size() == kArms) break;
        if (auto arm = examine(limb, worker, points, part_points, forward)) arms_.push_back(*arm);
    }
    return arms_;
}

Eigen::Vector3d ArmFinder::head_centre(const WorkerBody& worker, const SurfacePoints& points) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (const uint32_t i : worker.points) {
        const Eigen::Vector3f from_top = points.positions[i] - worker.head_top;
        if (from_top.z() < -0.22F || from_top.head<2>().norm() > 0.18F) continue;
        const Eigen::Vector3d p = points.positions[i].cast<double>();
        const uint8_t sensor = points.sensor[i];
        sum += p;
        if (sensor < places_.size()) sum += kHeadShell * (p - places_[sensor]).normalized();
        ++count;
    }
    return count > 0 ? Eigen::Vector3d(sum / count) : worker.head_top.cast<double>();
}

std::optional<ArmCluster> ArmFinder::examine(const Limb& limb, const WorkerBody& worker,
                                             const SurfacePoints& points,
                                             std::span<const uint8_t> part_points,
                                             const Eigen::Vector3d& forward) {
    if (limb.length < params_.min_length_m) return std::nullopt;
    if (worker.lattice.centre(limb.tip).z() < params_.min_tip_height_m) return std::nullopt;
    ArmCluster arm;
    arm.length = limb.length;
    const auto line = fit(limb, worker, points);
    if (!line) return std::nullopt;
    arm.axis = line->direction;
    arm.width = width_around(*line, points);
    arm.tip = find_tip(*line, points, part_points);
    if (arm.width > params_.max_width_m || arm.axis.z() < -params_.steepest_down) return std::nullopt;

    Eigen::Vector3d middle = (head_ + worker.middle.cast<double>()) / 2;
    if ((arm.tip - middle).head<2>().norm() < params_.min_off_trunk_m) return std::nullopt;
    // Reaching forward or sideways, not back.
    if ((arm.tip - middle).dot(forward) < 0 && arm.axis.dot(forward) < 0) return std::nullopt;

    const double upper = std::min<double>(limb.to_tip.back(), 0.55);
    arm.root = mean_of_voxels(limb, worker.lattice, upper - 0.1, upper);
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ());
    arm.side = (arm.root - middle).dot(right) > 0 ? ArmSide::right : ArmSide::left;
    arm.eye = head_;
    arm.eye.z() = worker.head_top.z() - params_.eye_of_height * worker.height;
    Eigen::Vector3d looking = arm.tip - head_;
    looking.z() = 0;
    if (looking.norm() > 0.05) arm.eye += 0.08 * looking.normalized();
    return arm;
}

std::optional<FittedLine> ArmFinder::fit(const Limb& limb, const WorkerBody& worker,
                                         const SurfacePoints& points) {
    const double piece = params_.forearm_of_height * std::max(worker.height, 1.2F);
    for (size_t k = 0; k < limb.voxels.size(); ++k)
        if (limb.to_tip[k] <= piece) in_limb_[limb.voxels[k]] = 1;
    limb_points_.clear();
    for (const uint32_t i : worker.points) {
        const int64_t v = worker.lattice.find(points.positions[i]);
        if (v >= 0 && in_limb_[v]) limb_points_.push_back(i);
    }
    for (const uint32_t v : limb.voxels) in_limb_[v] = 0;
    constexpr size_t kFewestPoints = 40;
    if (limb_points_.size() < kFewestPoints) return std::nullopt;

    const Eigen::Vector3d end = mean_of_voxels(limb, worker.lattice, 0, 0.08);
    const Eigen::Vector3d start = mean_of_voxels(limb, worker.lattice, piece - 0.1, piece);
    if ((end - start).norm() < 0.05) return std::nullopt;
    std::optional<FittedLine> line = FittedLine{(end + start) / 2, (end - start).normalized()};
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds && line; ++round) line = regress(*line, points);
    return line;
}

/// One round of eq. 5.3 along the line of the round before. Each slice across the arm gives one point a
/// sensor: the mean of the seen side, moved by pi/4 of the radius away from the sensor to the middle of the
/// round limb.
std::optional<FittedLine> ArmFinder::regress(const FittedLine& line, const SurfacePoints& points) {
    slices_.assign(kSlices * places_.size(), SliceSum{});
    for (const uint32_t i : limb_points_) {
        const Eigen::Vector3d p = points.positions[i].cast<double>();
        const double t = (p - line.point).dot(line.direction) / kSliceLength + kSlices / 2.0;
        const uint8_t sensor = points.sensor[i];
        if (t < 0 || t >= kSlices || sensor >= places_.size()) continue;
        SliceSum& slice = slices_[static_cast<size_t>(t) * places_.size() + sensor];
        const Eigen::Vector3d sideways = line.direction.cross(p - places_[sensor]).normalized();
        const double s = sideways.dot(p - line.point);
        ++slice.count;
        slice.sum += p;
        slice.sideways += s;
        slice.sideways2 += s * s;
    }
    centres_.clear();
    weights_.clear();
    for (size_t k = 0; k < slices_.size(); ++k) {
        const SliceSum& slice = slices_[k];
        if (slice.count < kFewestInSlice) continue;
        const Eigen::Vector3d mean = slice.sum / slice.count;
        const double s = slice.sideways / slice.count;
        const double variance = std::max(slice.sideways2 / slice.count - s * s, 0.0);
        const double radius = std::min(std::sqrt(3 * variance), kThickestRadius);
        Eigen::Vector3d view = mean - places_[k % places_.size()];
        view -= view.dot(line.direction) * line.direction;
        if (view.norm() < 1e-3) continue;
        centres_.emplace_back(mean + std::numbers::pi / 4 * radius * view.normalized());
        weights_.push_back(std::sqrt(static_cast<double>(slice.count)));
    }
    auto fitted = fit_along(centres_, weights_, line.direction);
    if (!fitted) return std::nullopt;
    // Once more without what lies off the line (a sleeve, a bit of the trunk).
    for (size_t k = 0; k < centres_.size(); ++k) {
        const double off = (centres_[k] - fitted->point).cross(fitted->direction).norm();
        weights_[k] /= 1 + std::pow(off / 0.02, 2);
    }
    return fit_along(centres_, weights_, fitted->direction);
}

double ArmFinder::width_around(const FittedLine& line, const SurfacePoints& points) const {
    double off2 = 0;
    for (const uint32_t i : limb_points_)
        off2 += (points.positions[i].cast<double>() - line.point).cross(line.direction).squaredNorm();
    return 2 * std::sqrt(off2 / static_cast<double>(limb_points_.size()));
}

/// The last of the foreground along the axis without a gap, the part's own points left out. Not only of the
/// limb's voxels: a finger has few points, and near the part its voxels are the part's.
Eigen::Vector3d ArmFinder::find_tip(const FittedLine& line, const SurfacePoints& points,
                                    std::span<const uint8_t> part_points) {
    const bool part_known = part_points.size() == points.size();
    const Eigen::Vector3f origin = line.point.cast<float>(), direction = line.direction.cast<float>();
    along_.clear();
    for (size_t i = 0; i < points.size(); ++i) {
        if (!points.foreground[i] || (part_known && part_points[i] != 0)) continue;
        const Eigen::Vector3f from = points.positions[i] - origin;
        const float t = from.dot(direction);
        if (t > -0.05F && t < 0.5F && from.squaredNorm() - t * t < kTipReach * kTipReach) along_.push_back(t);
    }
    std::sort(along_.begin(), along_.end());
    size_t end = 0;
    while (end < along_.size() && (along_[end] < 0 || end == 0 || along_[end] - along_[end - 1] < kTipGap))
        ++end;
    const float tip = end > kTipRank ? std::max(along_[end - 1 - kTipRank], 0.0F) : 0.0F;
    return line.point + static_cast<double>(tip) * line.direction;
}

}  // namespace deixis
