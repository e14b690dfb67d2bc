// A small work cell to test part tracking in: meshes rendered into two noisy Kinect-like depth images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/ray_caster.h"
#include "tracking/geometry/rigid_transform.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/geometry/surface_mesh.h"
#include "tracking/volume/surface_points.h"

namespace deixis::synthetic {

SurfaceMesh box(const Eigen::Vector3f& min, const Eigen::Vector3f& max);
SurfaceMesh capsule(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius);
SurfaceMesh moved(const SurfaceMesh& mesh, const RigidTransform& to_from);

/// A sheet without thickness: `profile` (y, z) points swept along x over `width`, bent to an arc of
/// `bend_radius` about the z axis when that is positive.
SurfaceMesh extruded_shell(const std::vector<Eigen::Vector2f>& profile, float width, float bend_radius);

/// A bumper-like shell of 3 mm wall without any CAD kernel: ends that wrap back, a rounded profile, dents
/// that differ left and right. x along the width, z up, outer skin towards -y. `other` is a visibly different
/// one.
SurfaceMesh bumper_shell(bool other);

/// A standing figure of capsules at (x, y) on the floor, facing `towards`; an arm reaches for `hand`.
SurfaceMesh person(const Eigen::Vector2f& place, const Eigen::Vector3f& hand);

/// Base plate, two posts and a beam under a part whose lower edge is at `height`.
SurfaceMesh trolley(const RigidTransform& world_from_part, const MeshBounds& part);

/// `shrink` divides the number of pixels along each side: smaller images for quick tests.
CalibratedSensor kinect(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, int shrink = 1);

/// Two sensors in front of the cell, 2.2 to 2.9 m from its middle, a little different for each seed.
std::vector<CalibratedSensor> two_kinects(unsigned seed, int shrink = 1);

struct NoiseLevel {
    double disparity_sigma = 0.7;  ///< in steps of 1/8 pixel
    double lateral_sigma = 0.5;    ///< [pixel]
    double dropout = 0.01;
};

/// What all sensors see of `scene` (world), with a floor of 6 x 6 m at z = 0; `seed` draws the noise.
Frameset render(const std::vector<CalibratedSensor>& sensors, const std::vector<SurfaceMesh>& scene,
                int64_t stamp_us, unsigned seed, const NoiseLevel& noise = {});

/// The points of the frameset inside the cell and above the floor; foreground where `empty` saw farther by 4
/// cm.
SurfacePoints surface_points(const std::vector<CalibratedSensor>& sensors, const Frameset& frameset,
                             const Frameset& empty);

/// Pose error: shift of the part's origin [mm] and turn [degree].
struct PoseError {
    double mm, degree;
};
PoseError error_between(const RigidTransform& a, const RigidTransform& b);

}  // namespace deixis::synthetic
