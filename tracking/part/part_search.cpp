// Pairs of FPFH matches with normals give whole poses; the best by depth evidence are refined and judged
// again.
#include "tracking/part/part_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace deixis {
namespace {

constexpr double distinct = 0.05;        // poses nearer than this are one [m]
constexpr double distinct_rough = 0.08;  // before refinement [m]
constexpr int quick_points = 90;         // reference points of the first judgement

/// SplitMix64 (Steele, Lea, Flood 2014): small, and the same everywhere.
class Draw {
  public:
    explicit Draw(uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ULL + 1) {}
    uint32_t below(size_t count) {
        state_ += 0x9E3779B97F4A7C15ULL;
        uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
        return static_cast<uint32_t>(((z ^ (z >> 31)) >> 32) * count >> 32);
    }

  private:
    uint64_t state_;
};

struct Match {
    Eigen::Vector3f scene, scene_normal, model, model_normal;
};

std::vector<Match> matches_of(const ReferenceModel& model, const SceneCloud& scene, int count) {
    const std::vector<Descriptor> seen =
        describe(scene.positions, scene.normals, model.params().descriptor_radius);
    const std::vector<int32_t> forward = nearest_descriptors(seen, model.descriptors(), count);
    std::vector<Match> matches;
    for (size_t i = 0; i < scene.size(); ++i)
        for (int k = 0; k < count; ++k)
            if (const int32_t m = forward[i * count + k]; m >= 0)
                matches.push_back({scene.positions[i], scene.normals[i], model.coarse()[m].position,
                                   model.coarse()[m].normal});
    return matches;
}

/// Axes from the line between two points and their mean normal; nothing when the normals lie along the line.
std::optional<Eigen::Matrix3f> pair_axes(const Eigen::Vector3f& line, const Eigen::Vector3f& normals) {
    const Eigen::Vector3f x = line.normalized();
    const Eigen::Vector3f y = normals - normals.dot(x) * x;
    if (y.squaredNorm() < 0.25F) return std::nullopt;
    Eigen::Matrix3f axes;
    axes.col(0) = x;
    axes.col(1) = y.normalized();
    axes.col(2) = x.cross(axes.col(1));
    return axes;
}

/// The pose in which both matches coincide, if distance and normals agree.
std::optional<RigidTransform> pose_of_pair(const Match& a, const Match& b, float shortest) {
    const Eigen::Vector3f ds = b.scene - a.scene, dm = b.model - a.model;
    const float ls = ds.norm(), lm = dm.norm();
    if (ls < shortest || std::abs(ls - lm) > 0.025F + 0.02F * lm) return std::nullopt;
    if (std::abs(a.scene_normal.dot(ds) / ls - a.model_normal.dot(dm) / lm) > 0.25F) return std::nullopt;
    if (std::abs(b.scene_normal.dot(ds) / ls - b.model_normal.dot(dm) / lm) > 0.25F) return std::nullopt;
    if (std::abs(a.scene_normal.dot(b.scene_normal) - a.model_normal.dot(b.model_normal)) > 0.3F)
        return std::nullopt;
    const auto scene = pair_axes(ds, a.scene_normal + b.scene_normal);
    const auto model = pair_axes(dm, a.model_normal + b.model_normal);
    if (!scene || !model) return std::nullopt;
    const Eigen::Matrix3d rotation = (*scene * model->transpose()).cast<double>();
    const Eigen::Vector3d shift =
        (0.5F * (a.scene + b.scene)).cast<double>() - rotation * (0.5F * (a.model + b.model)).cast<double>();
    return RigidTransform{rotation, shift};
}

/// Best first; of two poses nearer than `apart` the worse goes. Keeps at most `count`.
std::vector<PoseCandidate> best_distinct(std::vector<PoseCandidate> candidates, const ReferenceModel& model,
                                         double apart, size_t count) {
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const PoseCandidate& a, const PoseCandidate& b) { return a.score > b.score; });
    std::vector<PoseCandidate> kept;
    for (const PoseCandidate& c : candidates) {
        if (kept.size() >= count) break;
        if (std::none_of(kept.begin(), kept.end(), [&](const PoseCandidate& k) {
                return pose_distance(model, k.world_from_part, c.world_from_part) < apart;
            }))
            kept.push_back(c);
    }
    return kept;
}

std::vector<PoseCandidate> drawn_poses(const ReferenceModel& model, const std::vector<Match>& matches,
                                       const DepthWitness& witness, uint64_t seed,
                                       const PartSearchParams& params) {
    Draw draw(seed);
    std::vector<PoseCandidate> poses;
    const auto shortest = static_cast<float>(0.2 * model.radius());
    const int stride = std::max<int>(1, static_cast<int>(model.coarse().size()) / quick_points);
    const double lowest_up = std::cos(std::min(params.max_tilt, std::numbers::pi));
    int judged = 0;
    for (int i = 0; i < params.pairs && judged < params.judged_pairs; ++i) {
        const Match& a = matches[draw.below(matches.size())];
        const Match& b = matches[draw.below(matches.size())];
        const auto pose = pose_of_pair(a, b, shortest);
        if (!pose || pose->rotation(2, 2) < lowest_up) continue;
        const PoseEvidence evidence = witness.ask(*pose, model.coarse(), judged % stride, stride, 0.03);
        ++judged;
        if (evidence.found < 8 || score_of(evidence) < 0.05) continue;
        poses.push_back({*pose, evidence, score_of(evidence), 0});
    }
    return poses;
}

void refine(PoseCandidate& candidate, const ReferenceModel& model, const SceneCloud& scene,
            const DepthWitness& witness, const std::vector<IcpStep>& steps) {
    const IcpResult fit = register_points(scene.points, model, candidate.world_from_part, steps);
    candidate.world_from_part = fit.world_from_part;
    candidate.weakest = fit.weakest;
    candidate.evidence = witness.ask(candidate.world_from_part, model.coarse(), 0, 1, 0);
    candidate.score = score_of(candidate.evidence);
}

}  // namespace

InvalidSettings PartSearchParams::validate() const {
    InvalidSettings bad;
    require_range(bad, "matches", matches, 1, 16);
    require_range(bad, "pairs", pairs, 1000, 1e7);
    require_range(bad, "judged_pairs", judged_pairs, 10, 1e5);
    require_range(bad, "refined", refined, 1, 1000);
    require_range(bad, "max_tilt", max_tilt, 0.05, 4);
    require_range(bad, "max_points", max_points, 100, 1e5);
    return bad;
}

double score_of(const PoseEvidence& e) {
    return e.facing > 0 ? (e.found - 0.5 * e.off - 2.0 * e.seen_through) / e.facing : 0;
}

double pose_distance(const ReferenceModel& model, const RigidTransform& a, const RigidTransform& b) {
    return (a * model.centre() - b * model.centre()).norm() + rotation_between(a, b) * model.radius();
}

std::vector<PoseCandidate> search_part(const ReferenceModel& model, const SceneCloud& scene,
                                       const DepthWitness& witness, uint64_t seed,
                                       const PartSearchParams& params) {
    const std::vector<Match> matches = matches_of(model, scene, params.matches);
    if (matches.size() < 10) return {};
    std::vector<PoseCandidate> poses = best_distinct(drawn_poses(model, matches, witness, seed, params),
                                                     model, distinct_rough, params.refined);
    for (PoseCandidate& p : poses) refine(p, model, scene, witness, {{0.12, 5}, {0.06, 5}});
    poses = best_distinct(std::move(poses), model, distinct, 8);
    for (PoseCandidate& p : poses) refine(p, model, scene, witness, {{0.05, 5}, {0.03, 6}});
    return best_distinct(std::move(poses), model, distinct, 8);
}

}  // namespace deixis
