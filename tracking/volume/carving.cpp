// Carving: views from calibration and frames; the kernels are in carving_kernel.
#include "tracking/volume/carving.h"

#include <algorithm>

#include "tracking/volume/carving_kernel.h"

namespace deixis {
namespace {

/// The squared radius up to which r * (1 + k1 r^2 + k2 r^4 + k3 r^6) rises: beyond it the polynomial folds
/// back and would put points from far outside into the image.
float reach_of_lens(const CameraModel& camera) {
    const auto& k = camera.distortion;
    constexpr double kLimit = 3.0;  // tangent of the widest half angle asked for
    for (double r = 0; r < kLimit; r += 0.002) {
        const double r2 = r * r;
        if (1 + r2 * (3 * k[0] + r2 * (5 * k[1] + r2 * 7 * k[4])) <= 0) return static_cast<float>(r2);
    }
    return static_cast<float>(kLimit * kLimit);
}

CarvingView view_of(const CalibratedSensor& sensor) {
    CarvingView view;
    view.width = sensor.camera.width;
    view.height = sensor.camera.height;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
            view.camera_from_world[4 * r + c] = static_cast<float>(sensor.camera_from_world.rotation(r, c));
        view.camera_from_world[4 * r + 3] = static_cast<float>(sensor.camera_from_world.translation[r]);
    }
    view.fx = static_cast<float>(sensor.camera.fx);
    view.fy = static_cast<float>(sensor.camera.fy);
    view.cx = static_cast<float>(sensor.camera.cx);
    view.cy = static_cast<float>(sensor.camera.cy);
    view.distorted = sensor.camera.has_distortion();
    for (size_t i = 0; i < 5; ++i) view.distortion[i] = static_cast<float>(sensor.camera.distortion[i]);
    view.max_radius2 = reach_of_lens(sensor.camera);
    view.depth.assign(static_cast<size_t>(view.width) * view.height, 0);
    return view;
}

}  // namespace

InvalidSettings VoxelCarver::Params::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "voxel_m", voxel_m, 0.005, 0.5);
    require_range(complaints, "penetration_m", penetration_m, 0, 5);
    require_range(complaints, "slack_m", slack_m, 0, 1);
    require_range(complaints, "step_per_m2", step_per_m2, 0, 0.1);
    require_range(complaints, "slack_steps", slack_steps, 0, 20);
    return complaints;
}

VoxelCarver::VoxelCarver(const std::vector<CalibratedSensor>& depth_sensors, const Box& cell, Params params)
    : params_(params) {
    for (const CalibratedSensor& sensor : depth_sensors) views_.push_back(view_of(sensor));
    grid_.lattice = VoxelLattice::covering(cell, params_.voxel_m);
    grid_.states.assign(grid_.lattice.size(), static_cast<uint8_t>(VoxelState::unknown));
    present_.reserve(views_.size());
}

const VoxelGrid& VoxelCarver::update(const Frameset& frameset, const ForegroundModel& foreground) {
    present_.clear();
    for (size_t s = 0; s < views_.size() && s < frameset.frames.size(); ++s) {
        CarvingView& view = views_[s];
        const DepthFrame& frame = frameset.frames[s];
        if (!frame.present || frame.depth.width != view.width || frame.depth.height != view.height) continue;
        const std::span<const uint8_t> mask = foreground.mask(s);
        for (size_t i = 0; i < view.depth.size(); ++i) {
            const float sign = 2.0F * static_cast<float>(mask[i]) - 1.0F;
            view.depth[i] = sign * (static_cast<float>(frame.depth.millimetres[i]) * 0.001F);
        }
        present_.push_back(&view);
    }
    const CarvingMargins margins{static_cast<float>(params_.slack_m),
                                 static_cast<float>(params_.slack_steps * params_.step_per_m2),
                                 static_cast<float>(params_.penetration_m)};
    carve(present_, grid_.lattice, margins, grid_.states);
    return grid_;
}

}  // namespace deixis
