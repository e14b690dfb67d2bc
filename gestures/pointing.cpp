// Regression of the arm's axis and the cut of the ray with the CAD surface.
#include "gestures/pointing.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

namespace deixis {
namespace {

PartSpot spot_at(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                 const Eigen::Vector3d& towards) {
    PartSpot spot{position.cast<double>(), normal.cast<double>()};
    if (spot.normal.dot(towards) > 0) spot.normal = -spot.normal;
    return spot;
}

constexpr int kRings = 6;         // of the cone, evenly spaced
constexpr int kInnerRings = 1;    // a ray whose inner rings miss has missed
constexpr double kInside = 0.03;  // how far behind the skin a fingertip is still likely [m]

/// A ray of the cone around the aim.
struct ConeRay {
    Eigen::Vector3d direction;
    int ring;
};

std::array<ConeRay, 1 + 3 * kRings*(kRings + 1)> cone_around(const Eigen::Vector3d& direction,
                                                             double half_angle) {
    std::array<ConeRay, 1 + 3 * kRings*(kRings + 1)> rays;
    rays[0] = {direction, 0};
    const Eigen::Vector3d across = direction.unitOrthogonal(), third = direction.cross(across);
    size_t next = 1;
    for (int ring = 1; ring <= kRings; ++ring) {
        const int count = 6 * ring;
        const double off = std::tan(half_angle * ring / kRings);
        for (int k = 0; k < count; ++k) {
            const double angle = 2 * std::numbers::pi * k / count;
            const Eigen::Vector3d side = std::cos(angle) * across + std::sin(angle) * third;
            rays[next++] = {(direction + off * side).normalized(), ring};
        }
    }
    return rays;
}

/// Minus the logarithm of how likely a spot is meant that lies `along` and `across` the ray from the
/// fingertip.
double unlikelihood(double along, double across, const PointingParams& params) {
    const double spread = std::tan(params.direction_sigma_deg * std::numbers::pi / 180.0);
    const double before = std::max(along, 0.0);
    const double misfit = across / (params.tip_sigma_m + spread * before);
    return 0.5 * misfit * misfit + (along >= 0 ? along / params.closeness_m : -along / kInside);
}

/// The mean of the spots in the cone, in the part frame; nothing when the ray misses.
std::optional<Eigen::Vector3d> mean_spot(const RayCaster& surface, const Eigen::Vector3d& tip,
                                         const Eigen::Vector3d& direction, const PointingParams& params) {
    // The fingertip may already lie a little inside: start behind it.
    const Eigen::Vector3d start = tip - params.touch_m * direction;
    const auto reach = static_cast<float>(params.max_reach_m + params.touch_m);
    const double half_angle = 2 * params.direction_sigma_deg * std::numbers::pi / 180.0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double total = 0;
    for (const ConeRay& ray : cone_around(direction, half_angle)) {
        if (ray.ring == kInnerRings + 1 && total == 0) return std::nullopt;
        const auto hit = surface.cast(start.cast<float>(), ray.direction.cast<float>(), 0, reach);
        if (!hit) continue;
        const Eigen::Vector3d spot = start + hit->distance * ray.direction;
        const double along = (spot - tip).dot(direction);
        const double across = (spot - tip - along * direction).norm();
        const double weight = std::exp(-unlikelihood(along, across, params));
        mean += weight * spot;
        total += weight;
    }
    if (!(total > 0)) return std::nullopt;
    return mean / total;
}

}  // namespace

InvalidSettings PointingParams::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "eye_weight", eye_weight, 0, 1);
    require_range(complaints, "max_reach_m", max_reach_m, 0.05, 10);
    require_range(complaints, "touch_m", touch_m, 0, 0.2);
    require_range(complaints, "snap_m", snap_m, 0, 0.5);
    require_range(complaints, "tip_sigma_m", tip_sigma_m, 0.001, 0.2);
    require_range(complaints, "direction_sigma_deg", direction_sigma_deg, 0, 20);
    require_range(complaints, "closeness_m", closeness_m, 0.01, 10);
    return complaints;
}

std::optional<FittedLine> fit_along(std::span<const Eigen::Vector3d> points, std::span<const double> weights,
                                    const Eigen::Vector3d& main_axis) {
    if (points.size() < 2 || points.size() != weights.size()) return std::nullopt;
    double total = 0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < points.size(); ++i) {
        total += weights[i];
        mean += weights[i] * points[i];
    }
    if (!(total > 0) || !mean.allFinite()) return std::nullopt;
    mean /= total;
    // Slope of all three coordinates over t = p . axis; the one along the axis comes out as 1.
    double spread = 0;
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d offset = points[i] - mean;
        const double t = offset.dot(main_axis);
        spread += weights[i] * t * t;
        slope += weights[i] * t * offset;
    }
    if (!(spread > 1e-9 * total)) return std::nullopt;
    return FittedLine{mean, (slope / spread).normalized()};
}

Eigen::Vector3d blend_directions(const Eigen::Vector3d& forearm, const Eigen::Vector3d& eye,
                                 const Eigen::Vector3d& tip, double eye_weight) {
    const Eigen::Vector3d sight = tip - eye;
    if (!(sight.norm() > 1e-6)) return forearm;
    const Eigen::Vector3d blend = (1 - eye_weight) * forearm + eye_weight * sight.normalized();
    return blend.norm() > 1e-6 ? Eigen::Vector3d(blend.normalized()) : forearm;
}

std::optional<MeantSpot> spot_on_part(const RayCaster& surface, const RigidTransform& world_from_part,
                                      const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                      const PointingParams& params) {
    if (!origin.allFinite() || !direction.allFinite() || direction.norm() < 0.5) return std::nullopt;
    const RigidTransform part_from_world = world_from_part.inverse();
    const Eigen::Vector3f o = (part_from_world * origin).cast<float>();
    const Eigen::Vector3d d = part_from_world.rotation * direction;
    if (const auto mean = mean_spot(surface, o.cast<double>(), d, params)) {
        const auto nearest = surface.nearest(mean->cast<float>(), 0.3F);
        if (!nearest) return std::nullopt;
        const double distance = (nearest->position - o).cast<double>().dot(d);
        return MeantSpot{spot_at(nearest->position, nearest->normal, d), distance, distance <= params.touch_m,
                         false};
    }
    // A near miss: the sample along the ray that comes nearest to the surface.
    std::optional<NearestPoint> best;
    double best_at = 0;
    for (double t = -params.touch_m; t <= params.max_reach_m; t += 0.02) {
        const auto nearest = surface.nearest(o + static_cast<float>(t) * d.cast<float>(),
                                             best ? best->distance : static_cast<float>(params.snap_m));
        if (!nearest || (best && nearest->distance >= best->distance)) continue;
        best = nearest;
        best_at = t;
    }
    if (!best) return std::nullopt;
    return MeantSpot{spot_at(best->position, best->normal, d), best_at, best_at <= params.touch_m, true};
}

}  // namespace deixis
