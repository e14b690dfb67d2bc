// The way of the data: foreground, surface, part, volume, worker, gesture.
#include "appliance/station/perception.h"

#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include <chrono>

#include "tracking/geometry/ray_caster.h"
#include "tracking/volume/cell_bounds.h"
#include "tracking/volume/live_background.h"

namespace deixis {
namespace {

/// Reads the milliseconds since the last reading: the only clock here, and it reaches nothing but `stage_ms`.
class Lap {
  public:
    double operator()() {
        const auto now = std::chrono::steady_clock::now();
        const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
        last_ = now;
        return ms;
    }

  private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

InvalidSettings PerceptionParams::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "part_margin_m", part_margin_m, 0.005, 0.2);
    require_range(complaints, "threads", threads, 1, 64);
    return complaints;
}

struct Perception::Stages {
    FrameGaps gaps;
    LiveBackground background;
    ForegroundModel foreground;
    SurfaceFusion surface;
    VoxelCarver carver;
    WorkerVolume worker;
    GestureTracker gesture;
    std::optional<PartTracker> tracker;
    RayCaster part_surface;
    std::vector<uint8_t> part_points;
    float part_margin;
    tbb::task_arena arena;

    Stages(const WorkCell& cell, const Box& bounds, const PerceptionParams& params)
        : gaps(params.gaps),
          background(cell.rig.sensors, cell.background, {}),
          foreground(cell.rig.sensors, cell.background, params.foreground),
          surface(cell.rig.sensors, bounds, params.surface),
          carver(cell.rig.sensors, bounds, params.carving),
          worker(params.worker),
          gesture(cell.rig, params.gesture),
          part_margin(static_cast<float>(params.part_margin_m)),
          arena(params.threads) {
        if (!cell.part) return;
        tracker.emplace(cell.part->model, cell.rig.sensors, params.part);
        part_surface.add(cell.part->mesh);
        part_surface.commit();
    }

    /// Which foreground points the tracked part explains; none while it is not tracked.
    void take_part_out(const PartEstimate& part, const SurfacePoints& points) {
        part_points.assign(points.size(), 0);
        if (part.state != PartState::tracking) return;
        const MeshBounds& bounds = tracker->model().bounds();
        const RigidTransform part_from_world = part.world_from_part.inverse();
        const Eigen::Matrix3f rotation = part_from_world.rotation.cast<float>();
        const Eigen::Vector3f translation = part_from_world.translation.cast<float>();
        const Eigen::Array3f low = bounds.min.array() - part_margin, high = bounds.max.array() + part_margin;
        for (size_t i = 0; i < points.size(); ++i) {
            if (!points.foreground[i]) continue;
            const Eigen::Vector3f p = rotation * points.positions[i] + translation;
            // Most of the worker is nowhere near the part: the box spares a look into a table too large for
            // the cache.
            if ((p.array() < low).any() || (p.array() > high).any()) continue;
            part_points[i] = tracker->model().distance_to_surface(p) < part_margin;
        }
    }
};

Perception::Perception(const WorkCell& cell, const PerceptionParams& params)
    : stages_(
          std::make_unique<Stages>(cell, cell_bounds(cell.rig, cell.rig.sensors, cell.background), params)) {}

Perception::~Perception() = default;

Perception::Observation Perception::update(const Frameset& paired) {
    Stages& s = *stages_;
    Observation observation;
    FrameResult& result = observation.result;
    result.timestamp_us = paired.timestamp_us;
    Lap lap;

    const Frameset& frameset = s.gaps.update(paired);
    s.background.update(frameset, s.foreground);
    s.foreground.update(frameset);
    const SurfacePoints& points = s.surface.update(frameset, s.foreground);
    result.stage_ms.foreground = lap();

    // Neither of the two reads what the other writes, so they may run side by side.
    const auto follow_part = [&] {
        Lap part_lap;
        if (s.tracker) result.part = s.tracker->update(frameset, points);
        s.take_part_out(result.part, points);
        result.stage_ms.part = part_lap();
    };
    const auto carve = [&] {
        Lap carve_lap;
        s.carver.update(frameset, s.foreground);
        result.stage_ms.carve = carve_lap();
    };
    s.arena.execute([&] { tbb::parallel_invoke(follow_part, carve); });
    lap();

    const WorkerBody& body = s.worker.update(frameset.timestamp_us, s.carver.grid(), points, s.part_points);
    observation.worker_present = body.present;
    result.stage_ms.worker = lap();

    const bool tracked = result.part.state == PartState::tracking;
    GestureInput input{frameset.timestamp_us, body, points, s.part_points, nullptr, std::nullopt, false};
    if (s.tracker) input.part_surface = &s.part_surface;
    if (tracked) {
        input.world_from_part = result.part.world_from_part;
        input.part_at_rest = result.part.at_rest;
    }
    GestureOutput gesture = s.gesture.update(input);
    result.pointing = gesture.ray;
    observation.mark = gesture.mark;
    result.stage_ms.gesture = lap();
    return observation;
}

void Perception::worker_voxels(std::vector<Eigen::Vector3f>& centres) const {
    const WorkerBody& body = stages_->worker.body();
    centres.clear();
    if (!body.present) return;
    for (const uint32_t voxel : body.voxels) centres.push_back(body.lattice.centre(voxel));
}

float Perception::voxel_size() const {
    return static_cast<float>(stages_->carver.params().voxel_m);
}

}  // namespace deixis
