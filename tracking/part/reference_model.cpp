// Builds the reference model: sample, describe, index.
#include "tracking/part/reference_model.h"

#include <algorithm>
#include <cmath>

namespace deixis {
namespace {

constexpr double most_cells = 6e6;      // of a grid: 24 MB
constexpr double most_points = 60'000;  // fine points

std::vector<Eigen::Vector3f> positions_of(const std::vector<SkinPoint>& skin) {
    std::vector<Eigen::Vector3f> positions;
    positions.reserve(skin.size());
    for (const SkinPoint& p : skin) positions.push_back(p.position);
    return positions;
}

std::vector<uint32_t> members_of(const std::vector<SkinPoint>& skin, bool outer) {
    std::vector<uint32_t> members;
    for (uint32_t i = 0; i < skin.size(); ++i)
        if (skin[i].outer == outer) members.push_back(i);
    return members;
}

/// Normals as a sensor's cloud would give them: averaged over the patch that a plane is fitted to there.
std::vector<Eigen::Vector3f> smoothed_normals(const std::vector<SkinPoint>& points, double radius) {
    std::vector<Eigen::Vector3f> normals;
    const auto squared = static_cast<float>(radius * radius);
    for (const SkinPoint& p : points) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (const SkinPoint& q : points)
            if (q.outer == p.outer && (q.position - p.position).squaredNorm() < squared &&
                q.normal.dot(p.normal) > 0)
                sum += q.normal;
        normals.push_back(sum.normalized());
    }
    return normals;
}

/// Widens spacing and cell for parts so large that tables would not fit.
ReferenceModelParams fitted(ReferenceModelParams params, const MeshBounds& bounds) {
    const Eigen::Array3d size =
        (bounds.max - bounds.min).cast<double>().array() + 2 * params.reach + 2 * params.grid_cell;
    params.grid_cell = std::max(params.grid_cell, std::cbrt(size.prod() / most_cells));
    const Eigen::Array3d box = (bounds.max - bounds.min).cast<double>().array();
    const double area = 2 * (box.x() * box.y() + box.y() * box.z() + box.z() * box.x());
    params.fine_spacing = std::max(params.fine_spacing, std::sqrt(area / most_points));
    const double widened = params.fine_spacing * 3 / params.coarse_spacing;
    if (widened > 1.01) params.coarse_spacing *= widened, params.descriptor_radius *= widened;
    return params;
}

}  // namespace

InvalidSettings ReferenceModelParams::validate() const {
    InvalidSettings bad;
    require_range(bad, "fine_spacing", fine_spacing, 0.002, 0.1);
    require_range(bad, "coarse_spacing", coarse_spacing, fine_spacing, 0.3);
    require_range(bad, "descriptor_radius", descriptor_radius, 2 * coarse_spacing, 1);
    require_range(bad, "grid_cell", grid_cell, 0.002, 0.1);
    require_range(bad, "reach", reach, 0.05, 0.5);
    return bad;
}

Result<std::shared_ptr<const ReferenceModel>> ReferenceModel::build(const SurfaceMesh& mesh,
                                                                    const ReferenceModelParams& params) {
    if (mesh.vertices.empty() || mesh.triangles.empty()) return fail("the part's mesh is empty.");
    std::shared_ptr<ReferenceModel> model(new ReferenceModel);
    model->bounds_ = bounds_of(mesh);
    model->params_ = fitted(params, model->bounds_);
    OuterSkinParams skin;
    skin.spacing = model->params_.fine_spacing;
    model->fine_ = sample_outer_skin(mesh, skin);
    skin.spacing = model->params_.coarse_spacing;
    model->coarse_ = sample_outer_skin(mesh, skin);
    const std::vector<uint32_t> outer = members_of(model->fine_, true);
    if (outer.size() < 50 || model->coarse_.size() < 10)
        return fail("the part's mesh shows too little surface to the outside to be recognised.");

    const std::vector<Eigen::Vector3f> fine = positions_of(model->fine_);
    const auto cell = static_cast<float>(model->params_.grid_cell),
               reach = static_cast<float>(model->params_.reach);
    model->outer_grid_ = NearestPointGrid(fine, outer, cell, reach);
    model->inner_grid_ = NearestPointGrid(fine, members_of(model->fine_, false), cell, reach);
    for (const uint32_t i : outer) model->centre_ += fine[i].cast<double>();
    model->centre_ /= static_cast<double>(outer.size());
    for (const auto& p : fine)
        model->radius_ = std::max(model->radius_, (p.cast<double>() - model->centre_).norm());

    // Front and back of a wall are described apart: a sensor never sees both within one neighbourhood.
    const std::vector<Eigen::Vector3f> normals =
        smoothed_normals(model->coarse_, 2.5 * model->params_.coarse_spacing);
    model->descriptors_.assign(model->coarse_.size(), Descriptor{});
    for (const bool side : {true, false}) {
        const std::vector<uint32_t> members = members_of(model->coarse_, side);
        std::vector<Eigen::Vector3f> p, n;
        for (const uint32_t i : members) p.push_back(model->coarse_[i].position), n.push_back(normals[i]);
        const std::vector<Descriptor> d = describe(p, n, model->params_.descriptor_radius);
        for (size_t i = 0; i < members.size(); ++i) model->descriptors_[members[i]] = d[i];
    }
    return model;
}

float ReferenceModel::distance_to_surface(const Eigen::Vector3f& p_part) const {
    auto best = static_cast<float>(params_.reach);
    for (const NearestPointGrid* grid : {&outer_grid_, &inner_grid_})
        if (const uint32_t i = grid->find(p_part); i != NearestPointGrid::none)
            best = std::min(best, (fine_[i].position - p_part).norm());
    return best;
}

}  // namespace deixis
