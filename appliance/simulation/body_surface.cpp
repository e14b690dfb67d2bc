// The body's primitives, their mesh and the skinning.
#include "appliance/simulation/body_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "appliance/simulation/implicit_solid.h"

namespace deixis {
namespace {

using Primitives = std::vector<SolidPrimitive>;

void add_cone(Primitives& out, BodyBone bone, const Eigen::Vector3d& a, double ra, const Eigen::Vector3d& b,
              double rb) {
    out.push_back({false, a.cast<float>(), b.cast<float>(), static_cast<float>(ra), static_cast<float>(rb),
                   static_cast<uint8_t>(bone)});
}

void add_ellipsoid(Primitives& out, BodyBone bone, const Eigen::Vector3d& centre,
                   const Eigen::Vector3d& half_axes) {
    out.push_back({true, centre.cast<float>(), half_axes.cast<float>(), 0, 0, static_cast<uint8_t>(bone)});
}

/// Radii in metres for a height of 1.75 m and girth 1.
Primitives body_primitives(const BodyDimensions& d) {
    const RestJoints r = rest_joints(d);
    const double s = d.height / 1.75, g = s * d.girth, h = d.height;
    Primitives out;
    add_ellipsoid(out, BodyBone::pelvis, {0, -0.012 * s, 0.525 * h}, {0.162 * g, 0.118 * g, 0.115 * s});
    add_ellipsoid(out, BodyBone::spine, {0, -0.002 * s, 0.615 * h}, {0.142 * g, 0.105 * g, 0.125 * s});
    add_ellipsoid(out, BodyBone::chest, {0, 0, 0.725 * h}, {0.165 * g, 0.118 * g, 0.165 * s});
    add_cone(out, BodyBone::chest,
             0.88 * r.shoulder[0] + Eigen::Vector3d(0, -0.01, 0.12 * d.shoulder_height()), 0.058 * g,
             0.88 * r.shoulder[1] + Eigen::Vector3d(0, -0.01, 0.12 * d.shoulder_height()), 0.058 * g);
    add_cone(out, BodyBone::neck, r.neck - Eigen::Vector3d(0, 0, 0.02 * h), 0.062 * s, r.skull, 0.056 * s);
    for (const Eigen::Vector3d& shoulder : r.shoulder)  // trapezius
        add_cone(out, BodyBone::chest, r.neck + Eigen::Vector3d(0, -0.01 * s, -0.01 * h), 0.055 * g,
                 0.8 * shoulder + Eigen::Vector3d(0, -0.012 * s, 0.2 * d.shoulder_height()), 0.052 * g);
    add_ellipsoid(out, BodyBone::head, {0, 0.008 * h, 0.938 * h}, {0.078 * s, 0.098 * s, 0.062 * h});
    add_ellipsoid(out, BodyBone::head, {0, 0.032 * h, 0.898 * h}, {0.052 * s, 0.052 * s, 0.045 * s});
    add_cone(out, BodyBone::head, {0, 0.058 * h, 0.936 * h}, 0.010 * s, {0, 0.070 * h, 0.922 * h}, 0.014 * s);
    for (size_t side = 0; side < 2; ++side) {
        const auto at = [&](BodyBone left) { return of_side(left, side); };
        const Eigen::Vector3d& axis = r.arm_axis[side];
        add_cone(out, at(BodyBone::left_upper_arm), r.shoulder[side], 0.056 * g, r.elbow[side], 0.041 * g);
        add_cone(out, at(BodyBone::left_forearm), r.elbow[side], 0.042 * g,
                 r.elbow[side] + 0.35 * d.forearm() * axis, 0.044 * g);
        add_cone(out, at(BodyBone::left_forearm), r.elbow[side] + 0.35 * d.forearm() * axis, 0.044 * g,
                 r.wrist[side], 0.029 * g);
        add_cone(out, at(BodyBone::left_thigh), r.hip[side], 0.090 * g, r.knee[side], 0.056 * g);
        add_cone(out, at(BodyBone::left_shank), r.knee[side], 0.055 * g, r.ankle[side], 0.038 * g);
        add_ellipsoid(out, at(BodyBone::left_shank), {r.knee[side].x(), -0.022 * s, 0.205 * h},
                      {0.050 * g, 0.054 * g, 0.11 * s});
        const double ankle = d.ankle_height();
        add_cone(out, at(BodyBone::left_foot), {r.ankle[side].x(), -0.045 * s, 0.55 * ankle}, 0.036 * s,
                 {r.ankle[side].x(), 0.09 * h, 0.42 * ankle}, 0.029 * s);
        add_cone(out, at(BodyBone::left_foot), {r.ankle[side].x(), -0.01 * s, ankle}, 0.038 * s,
                 {r.ankle[side].x(), 0.05 * h, 0.6 * ankle}, 0.034 * s);
    }
    return out;
}

/// Fist with thumb and index finger; thumb side is +y at rest, palm inwards and down.
Primitives hand_primitives(const BodyDimensions& d, size_t side) {
    const RestJoints r = rest_joints(d);
    const double s = d.height / 1.75;
    const Eigen::Vector3d& axis = r.arm_axis[side];
    const Eigen::Vector3d thumb_side = Eigen::Vector3d::UnitY();
    const Eigen::Vector3d palm = Eigen::Vector3d(side == 0 ? 1 : -1, 0, -1).normalized();
    const auto at = [&](double along, double to_thumb, double to_palm) {
        return Eigen::Vector3d(r.wrist[side] + s * (along * axis + to_thumb * thumb_side + to_palm * palm));
    };
    Primitives out;
    const BodyBone hand = of_side(BodyBone::left_hand, side);
    add_cone(out, hand, at(-0.03, 0, 0), 0.027 * s, at(0.02, 0, 0), 0.026 * s);
    add_cone(out, hand, at(0.035, 0.012, 0.002), 0.021 * s, at(0.088, 0.004, 0.004), 0.017 * s);
    add_cone(out, hand, at(0.035, -0.020, 0.002), 0.020 * s, at(0.082, -0.040, 0.008), 0.016 * s);
    add_cone(out, hand, at(0.088, -0.018, 0.022), 0.014 * s, at(0.072, -0.042, 0.034),
             0.014 * s);  // folded fingers
    add_cone(out, hand, at(0.062, -0.016, 0.040), 0.013 * s, at(0.055, -0.042, 0.040), 0.013 * s);
    add_cone(out, hand, at(0.03, 0.026, 0.014), 0.014 * s, at(0.075, 0.022, 0.038), 0.011 * s);  // thumb
    add_cone(out, of_side(BodyBone::left_finger, side), r.knuckle[side], 0.0115 * s, r.finger_joint[side],
             0.0095 * s);
    const Eigen::Vector3d tip = r.fingertip[side] - 0.0075 * s * axis;  // the cap ends at the fingertip
    add_cone(out, of_side(BodyBone::left_fingertip, side), r.finger_joint[side], 0.0095 * s, tip, 0.0075 * s);
    return out;
}

}  // namespace

BodySurface::BodySurface(const BodyDimensions& dimensions, double cell) {
    // Weights fall off with the distance to each bone's own primitives; the softness sets how wide a joint
    // bends.
    const auto grow = [&](const Primitives& primitives, double fillet, double edge, float softness) {
        const SurfaceMesh mesh =
            mesh_of_union(primitives, static_cast<float>(fillet), static_cast<float>(edge));
        for (const Eigen::Vector3f& v : mesh.vertices) {
            std::array<float, body_bone_count> distance;
            distance.fill(1e9F);
            for (const SolidPrimitive& p : primitives)
                distance[p.bone] = std::min(distance[p.bone], distance_to(p, v));
            std::array<uint8_t, body_bone_count> order;
            std::iota(order.begin(), order.end(), uint8_t{0});
            std::stable_sort(order.begin(), order.end(),
                             [&](uint8_t a, uint8_t b) { return distance[a] < distance[b]; });
            Weights w;
            float sum = 0;
            for (size_t i = 0; i < 4; ++i) {
                w.bone[i] = order[i];
                w.share[i] = std::exp(-(distance[order[i]] - distance[order[0]]) / softness);
                if (w.share[i] < 0.01F) w.share[i] = 0;
                sum += w.share[i];
            }
            for (float& share : w.share) share /= sum;
            weights_.push_back(w);
        }
        append(rest_, mesh);
    };
    grow(body_primitives(dimensions), 0.035, cell, 0.020F);
    for (size_t side = 0; side < 2; ++side) grow(hand_primitives(dimensions, side), 0.008, cell / 3, 0.004F);
}

void BodySurface::move(const BodyPlaces& places, std::vector<Eigen::Vector3f>& vertices) const {
    std::array<Eigen::Matrix3f, body_bone_count> rotation;
    std::array<Eigen::Vector3f, body_bone_count> translation;
    for (size_t b = 0; b < body_bone_count; ++b) {
        rotation[b] = places.world_from_rest[b].rotation.cast<float>();
        translation[b] = places.world_from_rest[b].translation.cast<float>();
    }
    vertices.resize(rest_.vertices.size());
    for (size_t i = 0; i < vertices.size(); ++i) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (size_t k = 0; k < 4; ++k) {
            const float share = weights_[i].share[k];
            if (share == 0) continue;
            const uint8_t b = weights_[i].bone[k];
            sum += share * (rotation[b] * rest_.vertices[i] + translation[b]);
        }
        vertices[i] = sum;
    }
}

}  // namespace deixis
