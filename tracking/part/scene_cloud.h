// The scene thinned to the spacing of the model: averaged points with normals of their own, for the search.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tracking/part/icp.h"
#include "tracking/volume/surface_points.h"

namespace deixis {

struct SceneCloud {
    std::vector<Eigen::Vector3f> positions;  ///< world [m]: mean of a sensor's points in a cell
    std::vector<Eigen::Vector3f>
        normals;                     ///< unit, towards the sensor; zero where the neighbourhood is too thin
    std::vector<ScenePoint> points;  ///< the same positions, for ICP

    size_t size() const { return positions.size(); }
};

/// Averages `points` (only the foreground ones when asked) over cells of `cell` [m], sensor by sensor, and
/// fits planes over `normal_radius` [m] of one sensor's view. Cells of fewer than three points are dropped;
/// of more than `most` cells an even selection stays. `eyes` are the sensors' places in the world.
/// Deterministic.
SceneCloud thin_scene(const SurfacePoints& points, const std::vector<Eigen::Vector3d>& eyes,
                      bool foreground_only, double cell, double normal_radius, size_t most);

}  // namespace deixis
