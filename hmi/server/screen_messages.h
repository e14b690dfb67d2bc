// The screen's binary messages and JSON views: part mesh, worker voxels, part, cell. Values in, bytes out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hmi/server/screen_feed.h"

namespace deixis {

/// Little-endian: u32 vertex count, f32 x, y, z a vertex [m], u32 triangle count, u32 a, b, c a triangle.
std::vector<uint8_t> encode_mesh(const SurfaceMesh& mesh);

/// Worker voxels, one WebSocket binary message, little-endian: "DXV1", u32 count, f32 voxel size [m], f32 x,
/// y, z of the origin (world [m]), i64 timestamp [us], then u16 i, j, k a voxel: its centre is origin + size
/// * (i, j, k). centres     world frame [m], any order, on one grid of `voxel_size` > 0; off-grid ones are
/// rounded to it Centres that are not finite or lie 65536 cells and more from the least corner are left out.
std::vector<uint8_t> encode_voxels(std::span<const Eigen::Vector3f> centres, float voxel_size,
                                   int64_t timestamp_us);

/// `{"type", "serial", "zones": [{"name", "min", "max"}], "mesh_etag"}`, the body of GET /api/part.
std::string part_json(const ScreenPart& part, const std::string& mesh_etag);

/// `{"sensors": [{"name", "kind", "width", "height", "fx", "fy", "cx", "cy", "rotation", "translation"}],
/// "cell": {"min", "max"} | null}`, the body of GET /api/cell; rotation and translation are
/// camera_from_world.
std::string cell_json(const SensorRig& rig);

}  // namespace deixis
