// Fused surface points: both depth images as one oriented cloud in the world frame.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace deixis {

/// Structure of arrays, all of the same length; buffers are reused from frame to frame. Order: sensor by
/// sensor, row-major within each.
struct SurfacePoints {
    std::vector<Eigen::Vector3f> positions;  ///< world [m]
    std::vector<Eigen::Vector3f> normals;    ///< unit, towards the sensor; zero where not computable
    std::vector<uint8_t> sensor;             ///< index among the depth sensors
    std::vector<uint8_t> foreground;         ///< 1 where the empty cell was not seen

    size_t size() const { return positions.size(); }
    void clear() {
        positions.clear();
        normals.clear();
        sensor.clear();
        foreground.clear();
    }
};

}  // namespace deixis
