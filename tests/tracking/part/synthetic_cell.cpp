// Renders with RayCaster; noise after Khoshelham and Oude Elberink (2012): steps of disparity, lateral
// jitter.
#include "tests/tracking/part/synthetic_cell.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace deixis::synthetic {

SurfaceMesh box(const Eigen::Vector3f& min, const Eigen::Vector3f& max) {
    SurfaceMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.emplace_back(i & 1 ? max.x() : min.x(), i & 2 ? max.y() : min.y(),
                                   i & 4 ? max.z() : min.z());
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

SurfaceMesh capsule(const Eigen::Vector3f& from, const Eigen::Vector3f& to, float radius) {
    constexpr int around = 16, rings = 10;
    const Eigen::Vector3f axis = (to - from).normalized();
    const Eigen::Vector3f side = axis.unitOrthogonal(), up = axis.cross(side);
    SurfaceMesh mesh;
    for (int r = 0; r <= rings; ++r) {
        const float latitude = std::numbers::pi_v<float> * (static_cast<float>(r) / rings - 0.5F);
        const Eigen::Vector3f middle = (r <= rings / 2 ? from : to) + axis * (radius * std::sin(latitude));
        for (int a = 0; a < around; ++a) {
            const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(a) / around;
            mesh.vertices.emplace_back(middle + radius * std::cos(latitude) *
                                                    (std::cos(angle) * side + std::sin(angle) * up));
        }
    }
    for (uint32_t r = 0; r < rings; ++r)
        for (uint32_t a = 0; a < around; ++a) {
            const uint32_t b = (a + 1) % around, low = r * around, high = low + around;
            mesh.triangles.push_back({low + a, low + b, high + a});
            mesh.triangles.push_back({low + b, high + b, high + a});
        }
    return mesh;
}

SurfaceMesh moved(const SurfaceMesh& mesh, const RigidTransform& to_from) {
    SurfaceMesh result = mesh;
    for (auto& v : result.vertices) v = (to_from * v.cast<double>()).cast<float>();
    return result;
}

SurfaceMesh extruded_shell(const std::vector<Eigen::Vector2f>& profile, float width, float bend_radius) {
    constexpr int columns = 60;
    SurfaceMesh mesh;
    const auto rows = static_cast<uint32_t>(profile.size());
    for (int c = 0; c <= columns; ++c) {
        const float x = width * (static_cast<float>(c) / columns - 0.5F);
        for (const auto& p : profile) {
            if (bend_radius > 0) {
                const float angle = x / bend_radius, r = bend_radius - p.x();
                mesh.vertices.emplace_back(r * std::sin(angle), bend_radius - r * std::cos(angle), p.y());
            } else {
                mesh.vertices.emplace_back(x, p.x(), p.y());
            }
        }
    }
    for (uint32_t c = 0; c < columns; ++c)
        for (uint32_t r = 0; r + 1 < rows; ++r) {
            const uint32_t a = c * rows + r, b = a + rows;
            mesh.triangles.push_back({a, b, a + 1});
            mesh.triangles.push_back({b, b + 1, a + 1});
        }
    return mesh;
}

SurfaceMesh bumper_shell(bool other) {
    constexpr int columns = 110, rows = 36;
    const double width = other ? 1.5 : 1.7, height = other ? 0.38 : 0.45;
    // Planform: a wide arc that turns sharply near the ends; profile: a belly and a ledge.
    const auto outside = [&](double s, double t) {
        const double x = s * width / 2, end = std::max(0.0, std::abs(s) - 0.8) / 0.2;
        const double back = (other ? 0.05 : 0.09) * s * s + 0.30 * end * end;
        const double belly = other ? 0.03 * std::tanh(12 * (t - 0.45)) + 0.05 * t
                                   : 0.05 * std::sin(3.0 * t) - 0.25 * std::pow(t, 6);
        double dent = 0;
        const auto press = [&](double at_s, double at_t, double half_s, double half_t, double depth) {
            const double a = std::abs(s - at_s) / half_s, b = std::abs(t - at_t) / half_t;
            dent += depth / (1 + std::exp(14 * (std::max(a, b) - 1)));
        };
        if (other) {
            press(-0.45, 0.25, 0.22, 0.14, 0.04);
            press(0.55, 0.72, 0.12, 0.10, 0.03);
        } else {
            press(0.02, 0.40, 0.32, 0.13, 0.03);
            press(-0.68, 0.25, 0.07, 0.12, 0.05);
            press(0.60, 0.22, 0.12, 0.08, 0.05);
        }
        return Eigen::Vector3d(x * (1 - 0.08 * end),
                               back - belly + dent + (other ? 0.12 : 0.10) * std::pow(t, 8), height * t);
    };
    SurfaceMesh mesh;
    for (const double wall : {0.0, 0.003})
        for (int c = 0; c <= columns; ++c)
            for (int r = 0; r <= rows; ++r) {
                const double s = 2.0 * c / columns - 1, t = 1.0 * r / rows, h = 1e-4;
                const Eigen::Vector3d du = outside(s + h, t) - outside(s - h, t),
                                      dv = outside(s, t + h) - outside(s, t - h);
                const Eigen::Vector3d inward = dv.cross(du).normalized();
                mesh.vertices.push_back((outside(s, t) + wall * inward).cast<float>());
            }
    const uint32_t side = (columns + 1) * (rows + 1);
    const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    };
    const auto at = [&](uint32_t c, uint32_t r) { return c * (rows + 1) + r; };
    for (uint32_t c = 0; c < columns; ++c)
        for (uint32_t r = 0; r < rows; ++r) {
            quad(at(c, r), at(c + 1, r), at(c + 1, r + 1), at(c, r + 1));
            quad(side + at(c, r), side + at(c, r + 1), side + at(c + 1, r + 1), side + at(c + 1, r));
        }
    for (uint32_t c = 0; c < columns; ++c)
        for (const uint32_t r : {0U, static_cast<uint32_t>(rows)})
            quad(at(c, r), at(c + 1, r), side + at(c + 1, r), side + at(c, r));
    for (uint32_t r = 0; r < rows; ++r)
        for (const uint32_t c : {0U, static_cast<uint32_t>(columns)})
            quad(at(c, r), at(c, r + 1), side + at(c, r + 1), side + at(c, r));
    return mesh;
}

SurfaceMesh person(const Eigen::Vector2f& place, const Eigen::Vector3f& hand) {
    const auto at = [&](float x, float y, float z) {
        return Eigen::Vector3f(place.x() + x, place.y() + y, z);
    };
    SurfaceMesh body = capsule(at(0, 0, 0.95F), at(0, 0, 1.35F), 0.17F);
    append(body, capsule(at(0, 0, 1.66F), at(0, 0, 1.72F), 0.10F));
    for (const float side : {-0.11F, 0.11F})
        append(body, capsule(at(side, 0, 0.05F), at(side, 0, 0.85F), 0.08F));
    append(body, capsule(at(-0.24F, 0, 0.9F), at(-0.22F, 0, 1.42F), 0.05F));
    append(body, capsule(at(0.22F, 0, 1.42F), hand, 0.045F));
    return body;
}

SurfaceMesh trolley(const RigidTransform& world_from_part, const MeshBounds& part) {
    // The stand follows the part's place and heading, standing upright under it.
    const Eigen::Vector3d middle = world_from_part * (0.5 * (part.min + part.max)).cast<double>();
    const double lowest = middle.z() - 0.5 * static_cast<double>(part.max.z() - part.min.z());
    SurfaceMesh stand = box({-0.6F, -0.3F, 0.10F}, {0.6F, 0.3F, 0.16F});
    for (const float x : {-0.4F, 0.4F})
        append(stand,
               box({x - 0.025F, 0.0F, 0.16F}, {x + 0.025F, 0.05F, static_cast<float>(lowest) + 0.15F}));
    const double heading = std::atan2(world_from_part.rotation(1, 0), world_from_part.rotation(0, 0));
    return moved(stand, {Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix(),
                         {middle.x(), middle.y(), 0}});
}

CalibratedSensor kinect(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, int shrink) {
    CalibratedSensor sensor;
    const double f = 575.8 / shrink;
    sensor.camera = {640 / shrink,   480 / shrink, f, f, (640.0 / shrink - 1) / 2, (480.0 / shrink - 1) / 2,
                     {0, 0, 0, 0, 0}};
    const Eigen::Vector3d z = (target - eye).normalized(), x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    sensor.camera_from_world.rotation.row(0) = x;
    sensor.camera_from_world.rotation.row(1) = z.cross(x);
    sensor.camera_from_world.rotation.row(2) = z;
    sensor.camera_from_world.translation = -(sensor.camera_from_world.rotation * eye);
    return sensor;
}

std::vector<CalibratedSensor> two_kinects(unsigned seed, int shrink) {
    std::mt19937 random(seed + 77);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2);
    std::vector<CalibratedSensor> sensors;
    for (const double side : {-1.0, 1.0}) {
        const Eigen::Vector3d eye(side * (1.6 + jitter(random)), -2.1 + jitter(random), 2.0 + jitter(random));
        sensors.push_back(kinect(eye, {0.3 * jitter(random), 0.3 * jitter(random), 0.75}, shrink));
        sensors.back().name = side < 0 ? "left" : "right";
    }
    return sensors;
}

Frameset render(const std::vector<CalibratedSensor>& sensors, const std::vector<SurfaceMesh>& scene,
                int64_t stamp_us, unsigned seed, const NoiseLevel& noise) {
    RayCaster caster;
    caster.add(box({-3, -3, -0.05F}, {3, 3, 0}));
    for (const SurfaceMesh& mesh : scene) caster.add(mesh);
    caster.commit();
    Frameset frameset{stamp_us, {}};
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const CalibratedSensor& sensor : sensors) {
        const CameraModel& camera = sensor.camera;
        const RigidTransform world_from_camera = sensor.camera_from_world.inverse();
        const Eigen::Vector3f eye = world_from_camera.translation.cast<float>();
        DepthFrame frame{true, stamp_us, 0, {}};
        frame.depth.resize(camera.width, camera.height);
        for (int v = 0; v < camera.height; ++v)
            for (int u = 0; u < camera.width; ++u) {
                const Eigen::Vector2d pixel(u + noise.lateral_sigma * normal(random),
                                            v + noise.lateral_sigma * normal(random));
                const Eigen::Vector3f d = (world_from_camera.rotation * camera.ray(pixel)).cast<float>();
                uint16_t mm = 0;
                const auto hit = caster.cast(eye, d);
                const bool steep = hit && std::abs(hit->normal.dot(d.normalized())) < 0.17F;
                if (hit && !steep && uniform(random) >= noise.dropout) {
                    const double bf = 0.075 * 575.8 * 8;
                    const double disparity = std::round(bf / static_cast<double>(hit->distance) +
                                                        noise.disparity_sigma * normal(random));
                    mm = static_cast<uint16_t>(std::clamp(std::lround(1000 * bf / disparity), 1L, 9000L));
                }
                frame.depth.millimetres[static_cast<size_t>(v) * camera.width + u] = mm;
            }
        frameset.frames.push_back(std::move(frame));
    }
    return frameset;
}

SurfacePoints surface_points(const std::vector<CalibratedSensor>& sensors, const Frameset& frameset,
                             const Frameset& empty) {
    SurfacePoints points;
    for (size_t s = 0; s < sensors.size(); ++s) {
        if (!frameset.frames[s].present) continue;
        const RigidTransform world_from_camera = sensors[s].camera_from_world.inverse();
        const DepthImage& depth = frameset.frames[s].depth;
        for (int v = 0; v < depth.height; ++v)
            for (int u = 0; u < depth.width; ++u) {
                const int mm = depth.at(u, v);
                if (mm == 0) continue;
                const Eigen::Vector3d p = world_from_camera * (mm * 1e-3 * sensors[s].camera.ray({u, v}));
                if (p.z() < 0.05 || p.z() > 2.2 || p.head<2>().cwiseAbs().maxCoeff() > 2) continue;
                const int before = empty.frames[s].depth.at(u, v);
                points.positions.push_back(p.cast<float>());
                points.normals.emplace_back(Eigen::Vector3f::Zero());
                points.sensor.push_back(static_cast<uint8_t>(s));
                points.foreground.push_back(before == 0 || mm < before - 40 ? 1 : 0);
            }
    }
    return points;
}

PoseError error_between(const RigidTransform& a, const RigidTransform& b) {
    return {1e3 * (a.translation - b.translation).norm(), rotation_between(a, b) * 180 / std::numbers::pi};
}

}  // namespace deixis::synthetic
