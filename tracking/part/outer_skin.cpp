// Skin of a mesh: quasi-random samples of both sides of its triangles, kept where rays of Embree get away.
#include "tracking/part/outer_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <unordered_map>

#include "tracking/geometry/ray_caster.h"

namespace deixis {
namespace {

constexpr double oversampling = 3;  // samples a kept point, so that thinning can choose well placed ones
constexpr int probe_stride = 6;     // the first look at a sample uses every sixth direction
constexpr int table_side = 24;      // cells along an edge of the cube map of directions

const std::array<Eigen::Vector3f, skin_directions>& all_directions() {
    static const auto directions = [] {
        std::array<Eigen::Vector3f, skin_directions> d;
        const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
        for (int i = 0; i < skin_directions; ++i) {
            const double z = 1 - (2.0 * i + 1) / skin_directions, r = std::sqrt(1 - z * z);
            d[i] = Eigen::Vector3d(r * std::cos(turn * i), r * std::sin(turn * i), z).cast<float>();
        }
        return d;
    }();
    return directions;
}

/// Cell of the cube map around the origin: face by the largest coordinate, then a square grid on it.
int cube_cell(const Eigen::Vector3f& v) {
    int axis = 0;
    v.cwiseAbs().maxCoeff(&axis);
    const float scale = 0.5F / std::abs(v[axis]);
    const auto cell = [&](float x) {
        return std::clamp(static_cast<int>((x * scale + 0.5F) * table_side), 0, table_side - 1);
    };
    const int face = 2 * axis + (v[axis] > 0 ? 1 : 0);
    return (face * table_side + cell(v[(axis + 1) % 3])) * table_side + cell(v[(axis + 2) % 3]);
}

std::array<uint8_t, 6 * table_side * table_side> make_direction_table() {
    std::array<uint8_t, 6 * table_side * table_side> table{};
    for (int face = 0; face < 6; ++face)
        for (int a = 0; a < table_side; ++a)
            for (int b = 0; b < table_side; ++b) {
                Eigen::Vector3f v;
                v[face / 2] = face % 2 ? 0.5F : -0.5F;
                v[(face / 2 + 1) % 3] = (static_cast<float>(a) + 0.5F) / table_side - 0.5F;
                v[(face / 2 + 2) % 3] = (static_cast<float>(b) + 0.5F) / table_side - 0.5F;
                int best = 0;
                for (int i = 1; i < skin_directions; ++i)
                    if (all_directions()[i].dot(v) > all_directions()[best].dot(v)) best = i;
                table[(face * table_side + a) * table_side + b] = static_cast<uint8_t>(best);
            }
    return table;
}

struct Sample {
    Eigen::Vector3f position, normal;
};

/// The R2 sequence (Roberts, 2018) over all triangles by area: even, and the same on every run.
std::vector<Sample> samples_of(const SurfaceMesh& mesh, double density) {
    std::vector<Sample> samples;
    double owed = 0.5;
    uint64_t count = 0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [ia, ib, ic] = mesh.triangles[t];
        const Eigen::Vector3f a = mesh.vertices[ia], e1 = mesh.vertices[ib] - a, e2 = mesh.vertices[ic] - a;
        const Eigen::Vector3f normal = triangle_normal(mesh, t);
        const double area = 0.5 * static_cast<double>(e1.cross(e2).norm());
        if (!(area > 0) || !normal.allFinite()) continue;
        for (owed += area * density; owed >= 1; owed -= 1, ++count) {
            double u = 0.7548776662466927 * static_cast<double>(count),
                   v = 0.5698402909980532 * static_cast<double>(count);
            u -= std::floor(u), v -= std::floor(v);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            samples.push_back({a + static_cast<float>(u) * e1 + static_cast<float>(v) * e2, normal});
        }
    }
    return samples;
}

double area_of(const SurfaceMesh& mesh) {
    double area = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        area += 0.5 *
                static_cast<double>(
                    (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm());
    return area;
}

/// Whether a ray from the sample gets away in direction `i`; never into the surface itself.
bool gets_away(const RayCaster& caster, const Sample& s, float lift, float far, int i) {
    const Eigen::Vector3f& d = skin_direction(i);
    return d.dot(s.normal) >= 0.05F && !caster.cast(s.position + lift * s.normal, d, 0, far);
}

bool sees_out(const RayCaster& caster, const Sample& s, float lift, float far) {
    for (int i = 0; i < skin_directions; i += probe_stride)
        if (gets_away(caster, s, lift, far, i)) return true;
    return false;
}

VisibleFrom look_around(const RayCaster& caster, const Sample& s, float lift, float far) {
    VisibleFrom visible;
    for (int i = 0; i < skin_directions; ++i)
        if (gets_away(caster, s, lift, far, i)) visible.set(static_cast<size_t>(i));
    return visible;
}

int64_t cell_key(const Eigen::Vector3f& p, double cell) {
    const auto part = [&](float x) {
        return static_cast<int64_t>(std::floor(static_cast<double>(x) / cell)) & 0x1FFFFF;
    };
    return (part(p.x()) << 42) | (part(p.y()) << 21) | part(p.z());
}

/// Thins to one sample for each cell and main direction of the normal: the one nearest to the middle of the
/// cell.
std::vector<Sample> thinned(const std::vector<Sample>& samples, double spacing) {
    struct Best {
        size_t sample;
        float off;
    };
    std::array<std::unordered_map<int64_t, Best>, 6> best;
    std::vector<bool> keep(samples.size(), false);
    for (size_t i = 0; i < samples.size(); ++i) {
        int axis = 0;
        samples[i].normal.cwiseAbs().maxCoeff(&axis);
        const Eigen::Vector3f c = samples[i].position / static_cast<float>(spacing);
        const float off = (c.array() - c.array().floor() - 0.5F).matrix().squaredNorm();
        auto& cells = best[2 * axis + (samples[i].normal[axis] > 0 ? 1 : 0)];
        const auto [entry, fresh] = cells.try_emplace(cell_key(samples[i].position, spacing), Best{i, off});
        if (!fresh && off < entry->second.off) {
            keep[entry->second.sample] = false;
            entry->second = {i, off};
        } else if (!fresh) {
            continue;
        }
        keep[i] = true;
    }
    std::vector<Sample> kept;
    for (size_t i = 0; i < samples.size(); ++i)
        if (keep[i]) kept.push_back(samples[i]);
    return kept;
}

/// Of two points back to back on one wall the one that sees less of the world is the inner.
void tell_inner_from_outer(std::vector<SkinPoint>& skin, double wall_max, double spacing) {
    const double cell = wall_max + spacing;
    std::unordered_map<int64_t, std::vector<uint32_t>> cells;
    for (uint32_t i = 0; i < skin.size(); ++i) cells[cell_key(skin[i].position, cell)].push_back(i);
    const auto step = static_cast<float>(cell);
    for (SkinPoint& p : skin) {
        float best = static_cast<float>(wall_max + 0.7 * spacing);
        const SkinPoint* back = nullptr;
        for (int n = 0; n < 27; ++n) {
            const Eigen::Vector3f offset = Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1).cast<float>();
            const auto found = cells.find(cell_key(p.position + offset * step, cell));
            if (found == cells.end()) continue;
            for (const uint32_t j : found->second) {
                const SkinPoint& q = skin[j];
                const Eigen::Vector3f d = q.position - p.position;
                if (q.normal.dot(p.normal) > -0.5F ||
                    std::abs(d.dot(p.normal)) > static_cast<float>(wall_max))
                    continue;
                if (d.norm() < best) best = d.norm(), back = &q;
            }
        }
        if (back != nullptr) p.outer = p.visible_from.count() >= back->visible_from.count();
    }
}

}  // namespace

const Eigen::Vector3f& skin_direction(int index) {
    return all_directions()[index];
}

int skin_direction_index(const Eigen::Vector3f& unit) {
    static const auto table = make_direction_table();
    return table[cube_cell(unit)];
}

InvalidSettings OuterSkinParams::validate() const {
    InvalidSettings bad;
    require_range(bad, "spacing", spacing, 1e-4, 1);
    require_range(bad, "openness_min", openness_min, 0, 0.5);
    require_range(bad, "wall_max", wall_max, 0, 0.1);
    return bad;
}

std::vector<SkinPoint> sample_outer_skin(const SurfaceMesh& mesh, const OuterSkinParams& params) {
    const double area = area_of(mesh);
    if (!(area > 0)) return {};
    const MeshBounds bounds = bounds_of(mesh);
    const float size = (bounds.max - bounds.min).norm();
    const float lift = 2e-5F * size, far = 2 * size;
    RayCaster caster;
    caster.add(mesh);
    caster.commit();

    std::vector<Sample> open;
    for (const Sample& s : samples_of(mesh, oversampling / (params.spacing * params.spacing)))
        for (const float side : {1.0F, -1.0F}) {
            const Sample sided{s.position, side * s.normal};
            if (sees_out(caster, sided, lift, far)) open.push_back(sided);
        }
    std::vector<SkinPoint> skin;
    for (const Sample& s : thinned(open, params.spacing)) {
        const VisibleFrom visible = look_around(caster, s, lift, far);
        if (static_cast<double>(visible.count()) >= params.openness_min * skin_directions / 2)
            skin.push_back({s.position, s.normal, visible, true});
    }
    tell_inner_from_outer(skin, params.wall_max, params.spacing);
    return skin;
}

}  // namespace deixis
