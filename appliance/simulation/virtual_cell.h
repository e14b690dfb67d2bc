// The simulated work cell: sensors, part on its trolley and worker at any time, as depth frames and as truth.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "appliance/simulation/scenario.h"
#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/rigid_transform.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

/// Names of the fifteen joints in the order of formats.md.
extern const std::array<const char*, 15> simulated_joint_names;

struct TruePointing {
    int hold = 0;  ///< counts the gestures of the session from 1
    bool left_arm = false;
    bool meant = false;
    bool touch = false;
    std::optional<Eigen::Vector3d> target_part;  ///< part frame [m]
};

/// What is true at one time; positions in the world frame [m].
struct CellTruth {
    std::optional<std::array<Eigen::Vector3d, 15>> joints;  ///< nothing while there is no worker
    std::array<Eigen::Vector3d, 2> fingertips{};            ///< left, right
    Eigen::Vector3d eye = Eigen::Vector3d::Zero();          ///< between the eyes
    std::optional<RigidTransform> world_from_part;          ///< nothing while there is no part in the cell
    std::optional<TruePointing> pointing;
};

/// When a frame is exposed and what its stamps say, all on the session clock but `host_us`.
struct FrameTiming {
    double time_s = 0;  ///< exposure, seconds of the script
    int64_t timestamp_us = 0;
    int64_t host_us = 0;
};

/// Deterministic: the same scenario, seed, mesh and frame give the same pixels for any order of calls, any
/// number of threads. Different sensors may be rendered from different threads at once; one sensor from one
/// thread at a time.
class VirtualCell {
  public:
    /// `part` in metres, part frame (ignored when the scenario has none). Refuses, naming file and key, a
    /// scenario that cannot be played: a spot that is not on the part's outer skin or out of reach, a clip
    /// that does not read.
    static Result<VirtualCell> create(const Scenario& scenario, uint64_t seed, const SurfaceMesh& part);

    ~VirtualCell();
    VirtualCell(VirtualCell&&) noexcept;
    VirtualCell& operator=(VirtualCell&&) noexcept;

    const SensorRig& rig() const;
    double duration_s() const;

    /// Number of frames that `sensor` delivers; the last ones are exposed before `duration_s`.
    int64_t frame_count(size_t sensor) const;
    FrameTiming timing(size_t sensor, int64_t frame) const;

    /// Frame number `frame` of `sensor` with noise and stamps. Buffers are reused.
    void render(size_t sensor, int64_t frame, DepthFrame& out);

    /// The scene at `time_s` as a perfect sensor would see it: no noise, no shadow, no range limit.
    void render_clean(size_t sensor, double time_s, DepthImage& out);

    /// The cell without people, part and trolley, per pixel the median of some noisy frames; 0 = unknown.
    DepthImage background(size_t sensor);

    CellTruth truth(double time_s) const;

    /// Body height [m], aim and the like, as drawn: one line for a person.
    std::string description() const;

  private:
    struct Impl;
    explicit VirtualCell(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace deixis
