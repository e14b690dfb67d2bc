// Embree scene behind RayCaster.
#include "tracking/geometry/ray_caster.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <vector>

namespace deixis {
namespace {

Eigen::Vector3f closest_on_triangle(const Eigen::Vector3f& p, const Eigen::Vector3f& a,
                                    const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
    // Ericson, Real-Time Collision Detection, 5.1.5: the Voronoi region of p decides.
    const Eigen::Vector3f ab = b - a, ac = c - a, ap = p - a;
    const float d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const Eigen::Vector3f bp = p - b;
    const float d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
    const Eigen::Vector3f cp = p - c;
    const float d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && (d4 - d3) >= 0 && (d5 - d6) >= 0)
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    const float denominator = 1.0F / (va + vb + vc);
    return a + ab * (vb * denominator) + ac * (vc * denominator);
}

/// As Embree keeps them: x, y, z one after the other.
void write_vertices(const std::vector<Eigen::Vector3f>& vertices, float* out) {
    for (const Eigen::Vector3f& v : vertices) out = std::copy_n(v.data(), 3, out);
}

}  // namespace

struct RayCaster::Impl {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::vector<SurfaceMesh> meshes;
    std::vector<RTCGeometry> geometries;

    Impl() : device(rtcNewDevice("threads=1,set_affinity=0")), scene(rtcNewScene(device)) {
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    }
    ~Impl() {
        for (RTCGeometry g : geometries) rtcReleaseGeometry(g);
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
};

RayCaster::RayCaster() : impl_(std::make_unique<Impl>()) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

uint32_t RayCaster::add(const SurfaceMesh& mesh) {
    RTCGeometry g = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
        g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), mesh.triangles.size()));
    write_vertices(mesh.vertices, vertices);
    if (!mesh.triangles.empty())
        std::memcpy(indices, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(uint32_t));
    rtcCommitGeometry(g);
    const auto index = static_cast<uint32_t>(impl_->geometries.size());
    rtcAttachGeometryByID(impl_->scene, g, index);
    impl_->geometries.push_back(g);
    impl_->meshes.push_back(mesh);
    return index;
}

void RayCaster::update(uint32_t index, const std::vector<Eigen::Vector3f>& vertices) {
    assert(vertices.size() == impl_->meshes[index].vertices.size());
    impl_->meshes[index].vertices = vertices;
    RTCGeometry g = impl_->geometries[index];
    write_vertices(vertices, static_cast<float*>(rtcGetGeometryBufferData(g, RTC_BUFFER_TYPE_VERTEX, 0)));
    rtcUpdateGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(g);
}

void RayCaster::commit() {
    rtcCommitScene(impl_->scene);
}

std::optional<RayHit> RayCaster::cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                                      float near, float far) const {
    if (!origin.allFinite() || !direction.allFinite()) return std::nullopt;
    RTCRayHit query{};
    query.ray.org_x = origin.x();
    query.ray.org_y = origin.y();
    query.ray.org_z = origin.z();
    query.ray.dir_x = direction.x();
    query.ray.dir_y = direction.y();
    query.ray.dir_z = direction.z();
    query.ray.tnear = near;
    query.ray.tfar = far;
    query.ray.mask = 0xFFFFFFFF;  // Debian's Embree honours masks: without it nothing is ever hit
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(impl_->scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const Eigen::Vector3f normal(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
    return RayHit{query.ray.tfar, query.hit.geomID, query.hit.primID, normal.normalized()};
}

std::optional<NearestPoint> RayCaster::nearest(const Eigen::Vector3f& p, float radius) const {
    if (!p.allFinite() || !(radius > 0)) return std::nullopt;
    struct Search {
        const std::vector<SurfaceMesh>* meshes;
        std::optional<NearestPoint> best;
    } search{&impl_->meshes, std::nullopt};
    RTCPointQuery query{};
    query.x = p.x();
    query.y = p.y();
    query.z = p.z();
    query.radius = radius;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(
        impl_->scene, &query, &context,
        [](RTCPointQueryFunctionArguments* args) {
            auto* s = static_cast<Search*>(args->userPtr);
            const SurfaceMesh& mesh = (*s->meshes)[args->geomID];
            const auto& [a, b, c] = mesh.triangles[args->primID];
            const Eigen::Vector3f from(args->query->x, args->query->y, args->query->z);
            const Eigen::Vector3f q =
                closest_on_triangle(from, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
            const float distance = (q - from).norm();
            if (distance >= args->query->radius) return false;
            args->query->radius = distance;
            s->best =
                NearestPoint{q, triangle_normal(mesh, args->primID), distance, args->geomID, args->primID};
            return true;
        },
        &search);
    return search.best;
}

}  // namespace deixis
