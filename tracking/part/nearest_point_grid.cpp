// Exact feature transform of the occupied cells, one axis after the other.
#include "tracking/part/nearest_point_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deixis {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Lower envelope of parabolas along one line of cells (Felzenszwalb and Huttenlocher, 2012, algorithm 1),
/// which carries along whose parabola wins. Buffers are reused from line to line.
class LineTransform {
  public:
    explicit LineTransform(int longest)
        : place_(longest), border_(longest + 1), distance_(longest), owner_(longest) {}

    void run(float* distances, uint32_t* owners, size_t stride, int length) {
        int last = -1;
        for (int q = 0; q < length; ++q) {
            distance_[q] = distances[q * stride];
            owner_[q] = owners[q * stride];
            if (owner_[q] == NearestPointGrid::none) continue;
            double border = -infinity;
            while (last >= 0) {
                const int p = place_[last];
                border = (static_cast<double>(distance_[q]) + 1.0 * q * q -
                          (static_cast<double>(distance_[p]) + 1.0 * p * p)) /
                         (2.0 * q - 2.0 * p);
                if (border > border_[last]) break;
                --last;
                border = -infinity;
            }
            place_[++last] = q;
            border_[last] = border;
        }
        if (last < 0) return;
        int k = 0;
        for (int q = 0; q < length; ++q) {
            while (k < last && border_[k + 1] < q) ++k;
            const int p = place_[k];
            distances[q * stride] = static_cast<float>(distance_[p] + static_cast<float>((q - p) * (q - p)));
            owners[q * stride] = owner_[p];
        }
    }

  private:
    std::vector<int> place_;
    std::vector<double> border_;
    std::vector<float> distance_;
    std::vector<uint32_t> owner_;
};

}  // namespace

NearestPointGrid::NearestPointGrid(const std::vector<Eigen::Vector3f>& points,
                                   const std::vector<uint32_t>& members, float cell, float margin)
    : inverse_cell_(1 / cell) {
    if (members.empty()) return;
    Eigen::Vector3f low = points[members[0]], high = low;
    for (const uint32_t i : members) low = low.cwiseMin(points[i]), high = high.cwiseMax(points[i]);
    origin_ = low.array() - margin - cell;
    size_ = ((high - low).array() + 2 * margin + 2 * cell)
                .unaryExpr([&](float x) { return std::ceil(x / cell); })
                .cast<int>();
    limit_ = size_.cast<float>();
    cells_.assign(static_cast<size_t>(size_.x()) * size_.y() * size_.z(), none);
    std::vector<float> distance(cells_.size(), std::numeric_limits<float>::max());

    // Several points in a cell: the one nearest to its middle stands for it.
    std::vector<float> off(cells_.size(), std::numeric_limits<float>::max());
    for (const uint32_t i : members) {
        const Eigen::Vector3f c = (points[i] - origin_) * inverse_cell_;
        const Eigen::Vector3i at = c.cast<int>().cwiseMin(size_ - Eigen::Vector3i::Ones());
        const size_t index = (static_cast<size_t>(at.z()) * size_.y() + at.y()) * size_.x() + at.x();
        const float d = (c - at.cast<float>() - Eigen::Vector3f::Constant(0.5F)).squaredNorm();
        if (d >= off[index]) continue;
        off[index] = d;
        cells_[index] = i;
        distance[index] = 0;
    }
    const auto sx = static_cast<size_t>(size_.x()), sxy = sx * size_.y();
    LineTransform line(size_.maxCoeff());
    for (int z = 0; z < size_.z(); ++z)
        for (int y = 0; y < size_.y(); ++y)
            line.run(&distance[z * sxy + y * sx], &cells_[z * sxy + y * sx], 1, size_.x());
    for (int z = 0; z < size_.z(); ++z)
        for (int x = 0; x < size_.x(); ++x)
            line.run(&distance[z * sxy + x], &cells_[z * sxy + x], sx, size_.y());
    for (int y = 0; y < size_.y(); ++y)
        for (int x = 0; x < size_.x(); ++x)
            line.run(&distance[y * sx + x], &cells_[y * sx + x], sxy, size_.z());
    const float reach = margin * inverse_cell_;
    for (size_t i = 0; i < cells_.size(); ++i)
        if (distance[i] > reach * reach) cells_[i] = none;
}

}  // namespace deixis
