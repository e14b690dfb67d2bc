// Ray and nearest-point queries against the plain loop over all triangles.
#include "tracking/geometry/ray_caster.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

namespace deixis {
namespace {

SurfaceMesh random_soup(unsigned seed, int triangles) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> place(-1, 1), size(-0.2F, 0.2F);
    SurfaceMesh mesh;
    for (int i = 0; i < triangles; ++i) {
        const Eigen::Vector3f a(place(random), place(random), place(random));
        for (int k = 0; k < 3; ++k)
            mesh.vertices.emplace_back(a + Eigen::Vector3f(size(random), size(random), size(random)));
        const auto n = static_cast<uint32_t>(3 * i);
        mesh.triangles.push_back({n, n + 1, n + 2});
    }
    return mesh;
}

/// Moller-Trumbore over every triangle.
float plain_cast(const SurfaceMesh& mesh, const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
    double best = std::numeric_limits<double>::infinity();
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
        const Eigen::Vector3d e1 = mesh.vertices[t[1]].cast<double>() - a,
                              e2 = mesh.vertices[t[2]].cast<double>() - a;
        const Eigen::Vector3d p = d.cross(e2);
        const double det = e1.dot(p);
        if (std::abs(det) < 1e-12) continue;
        const Eigen::Vector3d s = o - a;
        const double u = s.dot(p) / det, v = d.dot(s.cross(e1)) / det, t0 = e2.dot(s.cross(e1)) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && t0 >= 0) best = std::min(best, t0);
    }
    return static_cast<float>(best);
}

TEST(RayCaster, AgreesWithThePlainLoop) {
    const SurfaceMesh mesh = random_soup(7, 300);
    RayCaster caster;
    caster.add(mesh);
    caster.commit();
    std::mt19937 random(8);
    std::normal_distribution<float> normal;
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3f o(2 * normal(random), 2 * normal(random), 2 * normal(random));
        const Eigen::Vector3f d = Eigen::Vector3f(normal(random), normal(random), normal(random)) - o;
        const float expected = plain_cast(mesh, o.cast<double>(), d.cast<double>());
        const auto hit = caster.cast(o, d);
        ASSERT_EQ(hit.has_value(), std::isfinite(expected)) << i;
        if (!hit) continue;
        ++hits;
        EXPECT_NEAR(hit->distance, expected, 1e-4F);
    }
    EXPECT_GT(hits, 100);
}

TEST(RayCaster, NearestPointIsNoFartherThanAnySampledSurfacePoint) {
    const SurfaceMesh mesh = random_soup(9, 100);
    RayCaster caster;
    caster.add(mesh);
    caster.commit();
    std::mt19937 random(10);
    std::uniform_real_distribution<float> place(-1, 1), share(0, 1);
    for (int i = 0; i < 50; ++i) {
        const Eigen::Vector3f p(place(random), place(random), place(random));
        const auto nearest = caster.nearest(p, 10);
        ASSERT_TRUE(nearest);
        EXPECT_NEAR((nearest->position - p).norm(), nearest->distance, 1e-5F);
        for (const auto& t : mesh.triangles)
            for (int k = 0; k < 20; ++k) {
                float u = share(random), v = share(random);
                if (u + v > 1) u = 1 - u, v = 1 - v;
                const Eigen::Vector3f q = mesh.vertices[t[0]] +
                                          u * (mesh.vertices[t[1]] - mesh.vertices[t[0]]) +
                                          v * (mesh.vertices[t[2]] - mesh.vertices[t[0]]);
                ASSERT_LE(nearest->distance, (q - p).norm() + 1e-5F);
            }
    }
}

TEST(RayCaster, MovedVerticesAreSeenAfterCommit) {
    SurfaceMesh mesh{{{-1, -1, 2}, {1, -1, 2}, {0, 1, 2}}, {{0, 1, 2}}};
    RayCaster caster;
    caster.add(mesh);
    caster.commit();
    EXPECT_NEAR(caster.cast({0, 0, 0}, {0, 0, 1})->distance, 2, 1e-6);
    for (auto& v : mesh.vertices) v.z() = 3;
    caster.update(0, mesh.vertices);
    caster.commit();
    EXPECT_NEAR(caster.cast({0, 0, 0}, {0, 0, 1})->distance, 3, 1e-6);
}

TEST(RayCaster, RefusesNaNAndEmptyScenes) {
    RayCaster caster;
    caster.commit();
    EXPECT_FALSE(caster.cast({0, 0, 0}, {0, 0, 1}));
    EXPECT_FALSE(caster.cast({NAN, 0, 0}, {0, 0, 1}));
    EXPECT_FALSE(caster.nearest({0, NAN, 0}, 1));
    EXPECT_FALSE(caster.nearest({0, 0, 0}, 0));
}

}  // namespace
}  // namespace deixis
