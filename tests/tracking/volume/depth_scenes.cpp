// Analytic rendering: one ray a pixel against floor, boxes and capsules.
#include "tests/tracking/volume/depth_scenes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace deixis {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

double hit_sphere(const Eigen::Vector3d& o, const Eigen::Vector3d& d, const Eigen::Vector3d& c, double r) {
    const Eigen::Vector3d m = o - c;
    const double a = d.squaredNorm(), b = m.dot(d), k = m.squaredNorm() - r * r, disc = b * b - a * k;
    if (disc < 0) return kNothing;
    const double t = (-b - std::sqrt(disc)) / a;
    return t > 0 ? t : kNothing;
}

double hit_capsule(const Eigen::Vector3d& o, const Eigen::Vector3d& d, const Capsule& capsule) {
    double best =
        std::min(hit_sphere(o, d, capsule.a, capsule.radius), hit_sphere(o, d, capsule.b, capsule.radius));
    const Eigen::Vector3d axis = (capsule.b - capsule.a).normalized(), m = o - capsule.a;
    const Eigen::Vector3d dp = d - d.dot(axis) * axis, mp = m - m.dot(axis) * axis;
    const double a = dp.squaredNorm(), b = mp.dot(dp), k = mp.squaredNorm() - capsule.radius * capsule.radius;
    const double disc = b * b - a * k;
    if (a < 1e-12 || disc < 0) return best;
    const double t = (-b - std::sqrt(disc)) / a, along = (m + t * d).dot(axis);
    if (t > 0 && along >= 0 && along <= (capsule.b - capsule.a).norm()) best = std::min(best, t);
    return best;
}

double hit_box(const Eigen::Vector3d& o, const Eigen::Vector3d& d, const Box& box) {
    double near = 0, far = kNothing;
    for (int axis = 0; axis < 3; ++axis) {
        double t0 = (box.min[axis] - o[axis]) / d[axis], t1 = (box.max[axis] - o[axis]) / d[axis];
        if (t0 > t1) std::swap(t0, t1);
        near = std::max(near, t0);
        far = std::min(far, t1);
    }
    return near <= far && near > 0 ? near : kNothing;
}

}  // namespace

CalibratedSensor sensor_looking(const Eigen::Vector3d& place, const Eigen::Vector3d& target, int width,
                                int height) {
    CalibratedSensor sensor;
    sensor.name = "sensor";
    sensor.camera = {width, height, 0.9 * width, 0.9 * width, (width - 1) / 2.0, (height - 1) / 2.0, {}};
    const Eigen::Vector3d z = (target - place).normalized();
    const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    RigidTransform world_from_camera;
    world_from_camera.rotation << x, z.cross(x), z;
    world_from_camera.translation = place;
    sensor.camera_from_world = world_from_camera.inverse();
    return sensor;
}

std::vector<CalibratedSensor> two_sensors() {
    return {sensor_looking({-1.9, -1.4, 2.5}, {0, 0.3, 0.9}),
            sensor_looking({2.0, -1.2, 2.4}, {0, 0.3, 0.9})};
}

DepthImage render(const CalibratedSensor& sensor, const DepthScene& scene, const SceneNoise& noise) {
    const RigidTransform world_from_camera = sensor.camera_from_world.inverse();
    const Eigen::Vector3d& o = world_from_camera.translation;
    DepthImage image;
    image.resize(sensor.camera.width, sensor.camera.height);
    const std::vector<Eigen::Vector2f> rays = sensor.camera.ray_table();
    for (size_t i = 0; i < image.millimetres.size(); ++i) {
        const Eigen::Vector2d ray = rays[i].cast<double>();
        const Eigen::Vector3d d = world_from_camera.rotation * Eigen::Vector3d(ray.x(), ray.y(), 1);
        double z = kNothing;
        if (scene.floor && d.z() < 0) z = -o.z() / d.z();
        for (const Capsule& capsule : scene.capsules) z = std::min(z, hit_capsule(o, d, capsule));
        for (const Box& box : scene.boxes) z = std::min(z, hit_box(o, d, box));
        image.millimetres[i] = z > 9.0 ? uint16_t{0} : static_cast<uint16_t>(std::lround(1000 * z));
    }
    return with_noise(image, noise);
}

DepthImage with_noise(const DepthImage& exact, const SceneNoise& noise) {
    std::mt19937 random(noise.seed);
    std::uniform_real_distribution<double> share(0, 1);
    std::normal_distribution<double> normal;
    DepthImage image = exact;
    for (uint16_t& mm : image.millimetres) {
        if (noise.dropout > 0 && share(random) < noise.dropout) mm = 0;
        if (mm == 0 || noise.step_per_m2 <= 0) continue;
        // Uniform steps of the inverse depth, half a step of Gaussian noise before rounding.
        const double steps = 1000.0 / mm / noise.step_per_m2 + 0.5 * normal(random);
        const double z = 1 / (std::max(std::round(steps), 1.0) * noise.step_per_m2);
        mm = static_cast<uint16_t>(std::lround(1000 * std::min(z, 60.0)));
    }
    return image;
}

Frameset render_all(const std::vector<CalibratedSensor>& sensors, const DepthScene& scene,
                    int64_t timestamp_us, const SceneNoise& noise) {
    Frameset frameset;
    frameset.timestamp_us = timestamp_us;
    for (size_t s = 0; s < sensors.size(); ++s) {
        SceneNoise own = noise;
        own.seed = noise.seed * 7919 + static_cast<uint32_t>(s) +
                   static_cast<uint32_t>(timestamp_us % 1'000'003) * 31;
        DepthFrame& frame = frameset.frames.emplace_back();
        frame.present = true;
        frame.timestamp_us = timestamp_us;
        frame.depth = render(sensors[s], scene, own);
    }
    return frameset;
}

std::vector<Capsule> standing_person(double x, double y, double height) {
    const double h = height;
    const auto at = [&](double across, double up) { return Eigen::Vector3d(x + across * h, y, up * h); };
    std::vector<Capsule> person;
    person.push_back({at(0, 0.90), at(0, 0.935), 0.062 * h});           // head
    person.push_back({at(0, 0.80), at(0, 0.88), 0.035 * h});            // neck
    person.push_back({at(-0.055, 0.56), at(-0.065, 0.75), 0.065 * h});  // trunk, two halves
    person.push_back({at(0.055, 0.56), at(0.065, 0.75), 0.065 * h});
    for (const double side : {-1.0, 1.0}) {
        person.push_back({at(side * 0.055, 0.03), at(side * 0.055, 0.50), 0.045 * h});  // leg
        person.push_back({at(side * 0.055, 0.78), at(side * 0.125, 0.78), 0.035 * h});  // shoulder
    }
    return person;
}

Capsule stretched_arm(double x, double y, double height, int side, const Eigen::Vector3d& target,
                      double reach) {
    const Eigen::Vector3d shoulder(x + side * 0.13 * height, y, 0.78 * height);
    return {shoulder, shoulder + reach * (target - shoulder).normalized(), 0.035};
}

}  // namespace deixis
