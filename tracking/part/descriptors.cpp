// FPFH by PCL, and an exhaustive, blocked search for nearest histograms.
#include "tracking/part/descriptors.h"

#include <pcl/features/fpfh.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace deixis {

std::vector<Descriptor> describe(const std::vector<Eigen::Vector3f>& positions,
                                 const std::vector<Eigen::Vector3f>& normals, double radius) {
    std::vector<Descriptor> descriptors(positions.size(), Descriptor{});
    if (positions.empty()) return descriptors;
    const pcl::PointCloud<pcl::PointNormal>::Ptr cloud(new pcl::PointCloud<pcl::PointNormal>);
    std::vector<size_t> origin;
    for (size_t i = 0; i < positions.size(); ++i) {
        if (!positions[i].allFinite() || !(normals[i].squaredNorm() > 0.5F)) continue;
        pcl::PointNormal p;
        p.getVector3fMap() = positions[i];
        p.getNormalVector3fMap() = normals[i];
        cloud->push_back(p);
        origin.push_back(i);
    }
    if (cloud->empty()) return descriptors;
    pcl::FPFHEstimation<pcl::PointNormal, pcl::PointNormal, pcl::FPFHSignature33> estimation;
    estimation.setInputCloud(cloud);
    estimation.setInputNormals(cloud);
    estimation.setSearchMethod(
        pcl::search::KdTree<pcl::PointNormal>::Ptr(new pcl::search::KdTree<pcl::PointNormal>));
    estimation.setRadiusSearch(radius);
    pcl::PointCloud<pcl::FPFHSignature33> histograms;
    estimation.compute(histograms);
    for (size_t i = 0; i < histograms.size(); ++i)
        if (std::all_of(histograms[i].histogram, histograms[i].histogram + 33,
                        [](float x) { return std::isfinite(x); }))
            std::copy_n(histograms[i].histogram, 33, descriptors[origin[i]].begin());
    return descriptors;
}

std::vector<int32_t> nearest_descriptors(const std::vector<Descriptor>& queries,
                                         const std::vector<Descriptor>& base, int count) {
    std::vector<int32_t> nearest(queries.size() * count, -1);
    if (base.empty()) return nearest;
    // Base by column: the inner loop runs over the base and vectorises.
    std::vector<float> columns(33 * base.size());
    for (size_t b = 0; b < base.size(); ++b)
        for (size_t k = 0; k < 33; ++k) columns[k * base.size() + b] = base[b][k];
    std::vector<float> distance(base.size());
    const size_t found = std::min<size_t>(count, base.size());
    for (size_t q = 0; q < queries.size(); ++q) {
        if (std::all_of(queries[q].begin(), queries[q].end(), [](float x) { return x == 0; })) continue;
        std::fill(distance.begin(), distance.end(), 0.0F);
        for (size_t k = 0; k < 33; ++k) {
            const float value = queries[q][k];
            const float* column = &columns[k * base.size()];
            for (size_t b = 0; b < base.size(); ++b) distance[b] += (column[b] - value) * (column[b] - value);
        }
        // Insertion into the few best: ties keep the smaller index.
        std::array<std::pair<float, int32_t>, 16> best;
        best.fill({std::numeric_limits<float>::max(), -1});
        const size_t keep = std::min<size_t>(found, best.size());
        for (size_t b = 0; b < base.size(); ++b) {
            if (distance[b] >= best[keep - 1].first) continue;
            size_t at = keep - 1;
            for (; at > 0 && best[at - 1].first > distance[b]; --at) best[at] = best[at - 1];
            best[at] = {distance[b], static_cast<int32_t>(b)};
        }
        for (int k = 0; k < count; ++k) nearest[q * count + k] = best[std::min<size_t>(k, keep - 1)].second;
    }
    return nearest;
}

}  // namespace deixis
