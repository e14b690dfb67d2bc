// Fast Point Feature Histograms of an oriented cloud (PCL inside), and their nearest neighbours.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace deixis {

/// FPFH: three histograms of eleven bins, each summing to 100 (R. B. Rusu, N. Blodow, M. Beetz, ICRA 2009;
/// thesis reference 137). All zero where the neighbourhood is empty or the normal is missing.
using Descriptor = std::array<float, 33>;

/// One descriptor a point. positions and normals have the same length; radius [m].
std::vector<Descriptor> describe(const std::vector<Eigen::Vector3f>& positions,
                                 const std::vector<Eigen::Vector3f>& normals, double radius);

/// For each query the `count` nearest of `base` by Euclidean distance, nearest first, ties by index:
/// row-major queries x count, count 1 to 16. Fewer than `count` in base: the row is filled up with the last.
/// Queries that are all zero get -1.
std::vector<int32_t> nearest_descriptors(const std::vector<Descriptor>& queries,
                                         const std::vector<Descriptor>& base, int count);

}  // namespace deixis
