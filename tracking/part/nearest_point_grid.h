// Nearest of a fixed set of points by table look-up: a grid of indices over their bounds and a margin.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace deixis {

class NearestPointGrid {
  public:
    static constexpr uint32_t none = 0xFFFFFFFF;

    NearestPointGrid() = default;

    /// Indexes `points[i]` for every i in `members`; `cell` and `margin` in the points' unit. Cells farther
    /// than `margin` from every point answer `none`. Exact distance transform of the occupied cells
    /// (Felzenszwalb and Huttenlocher, 2012): the answer is at most one cell diagonal farther than the
    /// nearest point.
    NearestPointGrid(const std::vector<Eigen::Vector3f>& points, const std::vector<uint32_t>& members,
                     float cell, float margin);

    /// Index of the nearest point, or `none`; NaN gives `none`.
    uint32_t find(const Eigen::Vector3f& p) const {
        const Eigen::Vector3f c = (p - origin_) * inverse_cell_;
        if (!(c.x() >= 0 && c.y() >= 0 && c.z() >= 0 && c.x() < limit_.x() && c.y() < limit_.y() &&
              c.z() < limit_.z()))
            return none;
        const auto x = static_cast<int>(c.x()), y = static_cast<int>(c.y()), z = static_cast<int>(c.z());
        return cells_[(static_cast<size_t>(z) * size_.y() + y) * size_.x() + x];
    }

    bool empty() const { return cells_.empty(); }

  private:
    Eigen::Vector3f origin_ = Eigen::Vector3f::Zero(), limit_ = Eigen::Vector3f::Zero();
    Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
    float inverse_cell_ = 0;
    std::vector<uint32_t> cells_;
};

}  // namespace deixis
