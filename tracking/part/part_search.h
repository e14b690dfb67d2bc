// Finds a part without a guess: FPFH matches, poses from pairs of them, judged by the depth images, refined
// by ICP.
#pragma once

#include <cstdint>
#include <vector>

#include "tracking/part/icp.h"
#include "tracking/part/pose_evidence.h"
#include "tracking/part/reference_model.h"
#include "tracking/part/scene_cloud.h"

namespace deixis {

struct PartSearchParams {
    int matches = 4;           ///< nearest model descriptors kept for each scene point
    int pairs = 400'000;       ///< pairs of matches drawn an attempt
    int judged_pairs = 4000;   ///< of them that pass the geometry are judged, at most
    int refined = 30;          ///< best distinct poses that ICP refines
    double max_tilt = 3.2;     ///< of the part's z axis against the world's [rad]; pi and more: any attitude
    double max_points = 7000;  ///< of the thinned scene
    InvalidSettings validate() const;
};

struct PoseCandidate {
    RigidTransform world_from_part;
    PoseEvidence evidence;  ///< of the outer and inner coarse points
    double score = 0;       ///< (found - off / 2 - 2 * seen through) / facing
    double weakest = 0;     ///< see IcpResult
};

double score_of(const PoseEvidence& evidence);

/// Largest move of any point of the part between two poses, bounded from above: shift at the part's centre
/// plus turn times the part's radius [m].
double pose_distance(const ReferenceModel& model, const RigidTransform& a, const RigidTransform& b);

/// The distinct poses (at least 5 cm apart) that explain the scene best, best first; empty when nothing does.
/// Bounded work. The same inputs and seed give the same poses.
std::vector<PoseCandidate> search_part(const ReferenceModel& model, const SceneCloud& scene,
                                       const DepthWitness& witness, uint64_t seed,
                                       const PartSearchParams& params);

}  // namespace deixis
