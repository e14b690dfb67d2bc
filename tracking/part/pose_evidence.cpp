// Projects reference points and compares depths.
#include "tracking/part/pose_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace deixis {
namespace {

constexpr double steepest = 0.26;  // cosine: surfaces seen flatter than 75 degrees give no reliable depth
constexpr double tolerance_base = 0.010;  // [m]
constexpr double seen_through_by = 0.05;  // [m]
constexpr double hidden_by = 0.05;        // [m]

/// Of the 3 x 3 pixels about (u, v) the measured depth nearest to z [m]; 0 where there is none.
double nearest_depth(const DepthImage& depth, int u, int v, double z) {
    double best = 0, off = std::numeric_limits<double>::infinity();
    for (int y = std::max(v - 1, 0); y <= std::min(v + 1, depth.height - 1); ++y)
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, depth.width - 1); ++x) {
            const uint16_t mm = depth.at(x, y);
            if (mm == 0) continue;
            const double d = mm * 1e-3;
            if (std::abs(d - z) < off) off = std::abs(d - z), best = d;
        }
    return best;
}

}  // namespace

DepthWitness::DepthWitness(const std::vector<CalibratedSensor>& sensors, const Frameset& frameset)
    : sensors_(&sensors), frameset_(&frameset) {
    for (const CalibratedSensor& s : sensors) eyes_.push_back(s.camera_from_world.inverse().translation);
}

PoseEvidence DepthWitness::ask(const RigidTransform& world_from_part, const std::vector<SkinPoint>& points,
                               int first, int stride, double slack) const {
    PoseEvidence evidence;
    double residual = 0;
    const RigidTransform part_from_world = world_from_part.inverse();
    for (size_t s = 0; s < sensors_->size() && s < frameset_->frames.size(); ++s) {
        const DepthFrame& frame = frameset_->frames[s];
        const CameraModel& camera = (*sensors_)[s].camera;
        if (!frame.present || frame.depth.width != camera.width || frame.depth.height != camera.height)
            continue;
        const RigidTransform camera_from_part = (*sensors_)[s].camera_from_world * world_from_part;
        const Eigen::Vector3f eye_part = (part_from_world * eyes_[s]).cast<float>();
        for (size_t i = first; i < points.size(); i += stride) {
            const SkinPoint& p = points[i];
            const Eigen::Vector3f to_eye = (eye_part - p.position).normalized();
            const double cosine = static_cast<double>(p.normal.dot(to_eye));
            if (cosine < steepest || !p.visible_from.test(skin_direction_index(to_eye))) continue;
            const Eigen::Vector3d q = camera_from_part * p.position.cast<double>();
            if (q.z() < 0.2) continue;
            const Eigen::Vector2d pixel = camera.project(q);
            if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < camera.width - 0.5 &&
                  pixel.y() < camera.height - 0.5))
                continue;
            ++evidence.facing;
            const double z = nearest_depth(frame.depth, static_cast<int>(std::lround(pixel.x())),
                                           static_cast<int>(std::lround(pixel.y())), q.z());
            if (z == 0) continue;
            const double behind = z - q.z(), step = depth_step(q.z());
            const double tolerance = tolerance_base + 0.7 * step + slack;
            if (std::abs(behind) * cosine <= tolerance) {
                ++evidence.found;
                residual += std::abs(behind) * cosine / tolerance;
            } else if (behind < -hidden_by - 2 * step) {
                ++evidence.hidden;
            } else {
                ++(behind * cosine > seen_through_by + step ? evidence.seen_through : evidence.off);
                residual += 1;
            }
        }
    }
    if (evidence.judged() > 0) evidence.residual = residual / evidence.judged();
    return evidence;
}

}  // namespace deixis
