// Row-hoisted SIMD carving: one row of voxels along x at a time, all views one after the other.
#include "tracking/volume/carving_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tracking/volume/carving_kernel.cpp"
#include <hwy/foreach_target.h>
// foreach_target comes first: it includes this file once a target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace deixis {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::ScalableTag<float>;
using Ints = hn::RebindToSigned<Floats>;
using FloatVec = hn::Vec<Floats>;

/// Raw image position of the normalised point (x, y), with the lens.
inline void distort(const CarvingView& view, FloatVec r2, FloatVec& x, FloatVec& y) {
    const Floats f;
    const auto k = [&](int i) { return hn::Set(f, view.distortion[static_cast<size_t>(i)]); };
    const FloatVec one = hn::Set(f, 1.0F), two = hn::Set(f, 2.0F);
    const FloatVec radial =
        hn::Add(one, hn::Mul(r2, hn::Add(k(0), hn::Mul(r2, hn::Add(k(1), hn::Mul(r2, k(4)))))));
    const FloatVec xy2 = hn::Mul(two, hn::Mul(x, y));
    const FloatVec dx = hn::Add(hn::Mul(k(2), xy2), hn::Mul(k(3), hn::Add(r2, hn::Mul(two, hn::Mul(x, x)))));
    const FloatVec dy = hn::Add(hn::Mul(k(2), hn::Add(r2, hn::Mul(two, hn::Mul(y, y)))), hn::Mul(k(3), xy2));
    x = hn::Add(hn::Mul(x, radial), dx);
    y = hn::Add(hn::Mul(y, radial), dy);
}

/// One view's votes on a row of voxels, the strongest of all views kept: 0 unknown, 1 occupied, 2 free.
/// `count` is a multiple of the lanes.
void vote_row(const CarvingView& view, const CarvingMargins& margins, const float* centres_x, float y,
              float z, size_t count, int32_t* votes) {
    const Floats f;
    const Ints n;
    const auto& p = view.camera_from_world;
    const FloatVec base_x = hn::Set(f, p[1] * y + (p[2] * z + p[3]));
    const FloatVec base_y = hn::Set(f, p[5] * y + (p[6] * z + p[7]));
    const FloatVec base_z = hn::Set(f, p[9] * y + (p[10] * z + p[11]));
    const FloatVec half = hn::Set(f, 0.5F), one = hn::Set(f, 1.0F), nothing = hn::Zero(f);
    const FloatVec width = hn::Set(f, static_cast<float>(view.width));
    const FloatVec height = hn::Set(f, static_cast<float>(view.height));
    const auto row_length = hn::Set(n, view.width);
    for (size_t i = 0; i < count; i += hn::Lanes(f)) {
        // What another view has seen through needs no more looking at.
        if (hn::AllTrue(n, hn::Eq(hn::LoadU(n, votes + i), hn::Set(n, 2)))) continue;
        const FloatVec cx = hn::LoadU(f, centres_x + i);
        const FloatVec pz = hn::Add(hn::Mul(hn::Set(f, p[8]), cx), base_z);
        const FloatVec inverse_z = hn::Div(one, pz);
        FloatVec x = hn::Mul(hn::Add(hn::Mul(hn::Set(f, p[0]), cx), base_x), inverse_z);
        FloatVec yy = hn::Mul(hn::Add(hn::Mul(hn::Set(f, p[4]), cx), base_y), inverse_z);
        auto visible = hn::Gt(pz, nothing);
        if (view.distorted) {
            const FloatVec r2 = hn::Add(hn::Mul(x, x), hn::Mul(yy, yy));
            visible = hn::And(visible, hn::Lt(r2, hn::Set(f, view.max_radius2)));
            distort(view, r2, x, yy);
        }
        const FloatVec u =
            hn::Floor(hn::Add(hn::Add(hn::Mul(hn::Set(f, view.fx), x), hn::Set(f, view.cx)), half));
        const FloatVec v =
            hn::Floor(hn::Add(hn::Add(hn::Mul(hn::Set(f, view.fy), yy), hn::Set(f, view.cy)), half));
        visible = hn::And(visible, hn::And(hn::And(hn::Ge(u, nothing), hn::Lt(u, width)),
                                           hn::And(hn::Ge(v, nothing), hn::Lt(v, height))));
        if (hn::AllFalse(f, visible)) continue;
        const auto iu = hn::ConvertTo(n, hn::IfThenElseZero(visible, u));
        const auto iv = hn::ConvertTo(n, hn::IfThenElseZero(visible, v));
        const FloatVec signed_depth =
            hn::GatherIndex(f, view.depth.data(), hn::Add(hn::Mul(iv, row_length), iu));
        const FloatVec depth = hn::Abs(signed_depth);
        visible = hn::And(visible, hn::Gt(depth, nothing));
        const FloatVec slack = hn::Add(hn::Set(f, margins.slack_constant),
                                       hn::Mul(hn::Set(f, margins.slack_per_m2), hn::Mul(depth, depth)));
        const auto is_free = hn::And(visible, hn::Lt(pz, hn::Sub(depth, slack)));
        const auto is_near = hn::Le(pz, hn::Add(depth, hn::Set(f, margins.penetration)));
        const auto is_occupied =
            hn::And(hn::AndNot(is_free, visible), hn::And(is_near, hn::Gt(signed_depth, nothing)));
        const auto vote = hn::IfThenElse(hn::RebindMask(n, is_free), hn::Set(n, 2),
                                         hn::IfThenElseZero(hn::RebindMask(n, is_occupied), hn::Set(n, 1)));
        hn::StoreU(hn::Max(hn::LoadU(n, votes + i), vote), n, votes + i);
    }
}

size_t padded_row(int voxels) {
    const size_t lanes = hn::Lanes(Floats());
    return (static_cast<size_t>(voxels) + lanes - 1) / lanes * lanes;
}

void carve_rows(std::span<const CarvingView* const> views, const VoxelLattice& lattice,
                const CarvingMargins& margins, uint8_t* states) {
    const size_t padded = padded_row(lattice.nx);
    static_assert(static_cast<int>(VoxelState::free) == 0 && static_cast<int>(VoxelState::occupied) == 1 &&
                  static_cast<int>(VoxelState::unknown) == 2);
    std::vector<float> centres_x(padded);
    std::vector<int32_t> votes(padded);
    for (size_t i = 0; i < padded; ++i)
        centres_x[i] = lattice.corner.x() + lattice.side * (static_cast<float>(i) + 0.5F);
    for (int iz = 0; iz < lattice.nz; ++iz)
        for (int iy = 0; iy < lattice.ny; ++iy) {
            const float y = lattice.corner.y() + lattice.side * (static_cast<float>(iy) + 0.5F);
            const float z = lattice.corner.z() + lattice.side * (static_cast<float>(iz) + 0.5F);
            std::fill(votes.begin(), votes.end(), 0);
            for (const CarvingView* view : views)
                vote_row(*view, margins, centres_x.data(), y, z, padded, votes.data());
            uint8_t* const row = states + lattice.index(0, iy, iz);
            const int32_t* const strongest = votes.data();
            for (int i = 0; i < lattice.nx; ++i) row[i] = static_cast<uint8_t>(2 - strongest[i]);
        }
}

}  // namespace HWY_NAMESPACE
}  // namespace deixis
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace deixis {

HWY_EXPORT(carve_rows);

void carve(std::span<const CarvingView* const> views, const VoxelLattice& lattice,
           const CarvingMargins& margins, std::vector<uint8_t>& states) {
    states.resize(lattice.size());
    if (states.empty()) return;
    HWY_DYNAMIC_DISPATCH(carve_rows)(views, lattice, margins, states.data());
}

}  // namespace deixis
#endif
