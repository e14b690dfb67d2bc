// The tracker's states: seek, confirm, follow. The difficulty lives in search, ICP, evidence and rest.
#include "tracking/part/part_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "tracking/part/icp.h"
#include "tracking/part/part_search.h"
#include "tracking/part/pose_evidence.h"
#include "tracking/part/rest_detector.h"
#include "tracking/part/scene_cloud.h"

namespace deixis {
namespace {

constexpr double near_margin = 0.08;     // points this far outside the part's box still take part in ICP [m]
constexpr size_t fewest_to_search = 60;  // thinned points
constexpr double longest_prediction_s = 0.2;

/// Velocity of the part, felt at its centre.
struct Motion {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of the centre, world [m/s]
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();   ///< world [rad/s]

    RigidTransform over(double seconds, const Eigen::Vector3d& centre_world) const {
        const double angle = turn.norm() * seconds;
        RigidTransform t;
        if (std::abs(angle) > 1e-12)
            t.rotation = Eigen::AngleAxisd(angle, turn.normalized()).toRotationMatrix();
        t.translation = centre_world + shift * seconds - t.rotation * centre_world;
        return t;
    }
};

Motion motion_between(const RigidTransform& before, const RigidTransform& after,
                      const Eigen::Vector3d& centre, double seconds) {
    const Eigen::AngleAxisd turn(after.rotation * before.rotation.transpose());
    return {(after * centre - before * centre) / seconds, turn.axis() * (turn.angle() / seconds)};
}

}  // namespace

InvalidSettings PartTrackerParams::validate() const {
    InvalidSettings bad;
    require_range(bad, "search_period", search_period, 1, 1000);
    require_range(bad, "max_tilt_deg", max_tilt_deg, 5, 180);
    require_range(bad, "found_fitness", found_fitness, 0.1, 1);
    require_range(bad, "found_residual", found_residual, 0.01, 1);
    require_range(bad, "held_fitness", held_fitness, 0.1, 1);
    require_range(bad, "held_residual", held_residual, 0.01, 1);
    require_range(bad, "found_share_min", found_share_min, 0.01, 1);
    require_range(bad, "held_share_min", held_share_min, 0.01, 1);
    require_range(bad, "seen_through_max", seen_through_max, 0, 1);
    require_range(bad, "rival_margin", rival_margin, 0, 1);
    require_range(bad, "lock_min", lock_min, 0, 0.1);
    require_range(bad, "confirm_frames", confirm_frames, 1, 100);
    require_range(bad, "lost_frames", lost_frames, 1, 100);
    require_range(bad, "rest_s", rest_s, 0.1, 10);
    require_range(bad, "rest_mm", rest_mm, 0.5, 50);
    require_range(bad, "motion_mm", motion_mm, rest_mm, 100);
    require_range(bad, "icp_points", icp_points, 200, 100000);
    return bad;
}

struct PartTracker::Impl {
    enum class Phase { seek, confirm, follow };

    std::shared_ptr<const ReferenceModel> model;
    std::vector<CalibratedSensor> sensors;
    Params params;
    std::vector<Eigen::Vector3d> eyes;
    RestDetector rest;
    PartSearchParams search;

    PartEstimate estimate;
    Phase phase = Phase::seek;
    RigidTransform pose;  ///< last measured
    Motion motion;
    int64_t pose_us = 0;
    int good_frames = 0, bad_frames = 0;
    uint64_t attempts = 0;
    int frames_to_attempt = 0;
    bool was_tracking = false;
    std::vector<uint32_t> near_indices;
    std::vector<ScenePoint> near_points;

    Impl(std::shared_ptr<const ReferenceModel> m, std::vector<CalibratedSensor> s, Params p)
        : model(std::move(m)),
          sensors(std::move(s)),
          params(p),
          rest(model->centre(), model->radius(), {p.rest_s, p.rest_mm * 1e-3, p.motion_mm * 1e-3, 60}) {
        for (const CalibratedSensor& sensor : sensors)
            eyes.push_back(sensor.camera_from_world.inverse().translation);
        search.max_tilt = params.max_tilt_deg * std::numbers::pi / 180;
        estimate.state = PartState::searching;
        estimate.reason = "The part has not been looked for yet.";
    }

    void report(PartState state, std::string reason) {
        estimate = PartEstimate{};
        estimate.state = state;
        estimate.reason = std::move(reason);
    }

    bool believable(const PoseEvidence& e, bool held) const {
        return e.fitness() >= (held ? params.held_fitness : params.found_fitness) &&
               e.residual <= (held ? params.held_residual : params.found_residual) &&
               e.found_share() >= (held ? params.held_share_min : params.found_share_min) &&
               e.seen_through_share() <= params.seen_through_max;
    }

    void seek(const Frameset& frameset, const SurfacePoints& points, const DepthWitness& witness);
    void gather_near(const Frameset& frameset, const SurfacePoints& points, const RigidTransform& predicted);
    void follow(const Frameset& frameset, const SurfacePoints& points, const DepthWitness& witness);
    void accept(const Frameset& frameset, const IcpResult& fit, const PoseEvidence& evidence,
                const DepthWitness& witness);
    void reject(const DepthWitness& witness, const std::string& why);
};

/// One attempt every `search_period` framesets, by turns over the foreground and over everything: the part
/// may have stood in the cell when the background was learned.
void PartTracker::Impl::seek(const Frameset& frameset, const SurfacePoints& points,
                             const DepthWitness& witness) {
    if (frames_to_attempt-- > 0) return;
    frames_to_attempt = params.search_period - 1;
    const uint64_t attempt = attempts++;
    const double spacing = model->params().coarse_spacing;
    const auto most = static_cast<size_t>(search.max_points);
    SceneCloud scene;
    if (attempt % 2 == 0) scene = thin_scene(points, eyes, true, spacing, 2.5 * spacing, most);
    if (scene.size() < fewest_to_search)
        scene = thin_scene(points, eyes, false, spacing, 2.5 * spacing, most);
    if (scene.size() < fewest_to_search) return report(PartState::absent, "The cell is empty.");

    const std::vector<PoseCandidate> found = search_part(*model, scene, witness, attempt, search);
    if (found.empty() || !believable(found[0].evidence, false))
        return report(PartState::absent, "Nothing in the cell looks like the part.");
    if (found[0].weakest < params.lock_min)
        return report(PartState::ambiguous,
                      "The part is seen, but what is seen of it can slide: not locked.");
    for (size_t i = 1; i < found.size(); ++i)
        if (found[i].evidence.residual < found[0].evidence.residual + params.rival_margin &&
            found[i].evidence.found > found[0].evidence.found / 2)
            return report(PartState::ambiguous,
                          "The part is seen, but two different poses explain it alike.");
    phase = Phase::confirm;
    pose = found[0].world_from_part;
    motion = {};
    pose_us = frameset.timestamp_us;
    good_frames = bad_frames = 0;
    rest.reset();
    report(PartState::searching, "A pose was found and is being confirmed.");
}

/// An even selection of the points around the predicted part, each sensor's moved to the frameset's own
/// instant.
void PartTracker::Impl::gather_near(const Frameset& frameset, const SurfacePoints& points,
                                    const RigidTransform& predicted) {
    const RigidTransform part_from_world = predicted.inverse();
    const Eigen::Matrix3f rotation = part_from_world.rotation.cast<float>();
    const Eigen::Vector3f translation = part_from_world.translation.cast<float>();
    const Eigen::Vector3f low = model->bounds().min.array() - static_cast<float>(near_margin);
    const Eigen::Vector3f high = model->bounds().max.array() + static_cast<float>(near_margin);
    near_indices.clear();
    for (uint32_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3f p = rotation * points.positions[i] + translation;
        if ((p.array() >= low.array()).all() && (p.array() <= high.array()).all()) near_indices.push_back(i);
    }
    std::vector<RigidTransform> to_now(sensors.size());
    for (size_t s = 0; s < sensors.size() && s < frameset.frames.size(); ++s) {
        const double late =
            1e-6 * static_cast<double>(frameset.frames[s].timestamp_us - frameset.timestamp_us);
        if (frameset.frames[s].present && std::abs(late) < 0.05)
            to_now[s] = motion.over(-late, predicted * model->centre());
    }
    near_points.clear();
    const size_t kept = std::min<size_t>(near_indices.size(), static_cast<size_t>(params.icp_points));
    for (size_t k = 0; k < kept; ++k) {
        const uint32_t i = near_indices[k * near_indices.size() / kept];
        const unsigned s = points.sensor[i];
        const Eigen::Vector3d p = to_now[s] * points.positions[i].cast<double>();
        const Eigen::Vector3d to_eye = eyes[s] - p;
        const double range = to_eye.norm(), sigma = 0.003 + 0.4 * depth_step(range);
        near_points.push_back(
            {p.cast<float>(), (to_eye / range).cast<float>(), static_cast<float>(1e-4 / (sigma * sigma))});
    }
}

void PartTracker::Impl::accept(const Frameset& frameset, const IcpResult& fit, const PoseEvidence& evidence,
                               const DepthWitness& witness) {
    const double seconds = 1e-6 * static_cast<double>(frameset.timestamp_us - pose_us);
    if (seconds > 0) motion = motion_between(pose, fit.world_from_part, model->centre(), seconds);
    pose = fit.world_from_part;
    pose_us = frameset.timestamp_us;
    bad_frames = 0;
    ++good_frames;
    if (phase == Phase::confirm && good_frames < params.confirm_frames) return;
    phase = Phase::follow;
    was_tracking = true;
    bool certain = true;
    if (rest.at_rest()) {
        const PoseEvidence still = witness.ask(rest.resting_pose(), model->coarse(), 0, 2, 0);
        certain = still.residual > evidence.residual + 0.008;
    }
    rest.add(frameset.timestamp_us, pose, certain);
    if (rest.at_rest() && !rest.leaving()) {
        motion = {};
        pose = rest.resting_pose();
    }
    estimate.state = PartState::tracking;
    estimate.world_from_part = pose;
    estimate.at_rest = rest.at_rest();
    estimate.fitness = evidence.fitness();
    estimate.reason.clear();
}

/// A frame without the part. One at rest keeps its pose for the few frames until it counts as lost; one that
/// moves is lost at once, because nobody knows where it went.
void PartTracker::Impl::reject(const DepthWitness& witness, const std::string& why) {
    ++bad_frames;
    if (phase == Phase::confirm || bad_frames >= params.lost_frames) {
        phase = Phase::seek;
        frames_to_attempt = 0;
        rest.reset();
        report(was_tracking ? PartState::lost : PartState::searching, why);
        was_tracking = false;
        return;
    }
    if (rest.at_rest() &&
        witness.ask(pose, model->coarse(), 0, 2, 0).seen_through_share() <= params.seen_through_max)
        return;
    report(PartState::lost, why);
}

void PartTracker::Impl::follow(const Frameset& frameset, const SurfacePoints& points,
                               const DepthWitness& witness) {
    const double seconds =
        std::clamp(1e-6 * static_cast<double>(frameset.timestamp_us - pose_us), 0.0, longest_prediction_s);
    const RigidTransform predicted = motion.over(seconds, pose * model->centre()) * pose;
    gather_near(frameset, points, predicted);
    double step = 0;
    for (const Eigen::Vector3d& eye : eyes) step += depth_step((predicted * model->centre() - eye).norm());
    const double gate = 0.02 + 0.6 * step / static_cast<double>(eyes.size());
    const IcpResult fit =
        rest.at_rest()
            ? register_points(near_points, *model, predicted, {{2 * gate, 2}, {gate, 3}})
            : register_points(near_points, *model, predicted, {{0.08, 3}, {1.5 * gate, 3}, {gate, 4}});
    const PoseEvidence evidence = witness.ask(fit.world_from_part, model->coarse(), 0, 2, 0);
    if (!believable(evidence, phase == Phase::follow))
        return reject(witness, "The part is not where it was.");
    if (fit.weakest < params.lock_min && !rest.at_rest())
        return reject(witness, "What is seen of the part can slide: not locked.");
    accept(frameset, fit, evidence, witness);
}

PartTracker::PartTracker(std::shared_ptr<const ReferenceModel> model,
                         std::vector<CalibratedSensor> depth_sensors, Params params)
    : impl_(std::make_unique<Impl>(std::move(model), std::move(depth_sensors), params)) {}
PartTracker::~PartTracker() = default;
PartTracker::PartTracker(PartTracker&&) noexcept = default;
PartTracker& PartTracker::operator=(PartTracker&&) noexcept = default;

const PartEstimate& PartTracker::update(const Frameset& frameset, const SurfacePoints& points) {
    const DepthWitness witness(impl_->sensors, frameset);
    if (impl_->phase == Impl::Phase::seek)
        impl_->seek(frameset, points, witness);
    else
        impl_->follow(frameset, points, witness);
    return impl_->estimate;
}

const PartEstimate& PartTracker::estimate() const {
    return impl_->estimate;
}
const ReferenceModel& PartTracker::model() const {
    return *impl_->model;
}

}  // namespace deixis
