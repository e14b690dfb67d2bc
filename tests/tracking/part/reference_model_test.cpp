// The reference model: its distance table against the exact surface, determinism, refusals.
#include "tracking/part/reference_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/tracking/part/synthetic_cell.h"
#include "tracking/geometry/ray_caster.h"

namespace deixis {
namespace {

using namespace synthetic;

TEST(ReferenceModel, DistanceIsWithinACentimetreOfTheSurface) {
    const SurfaceMesh mesh = bumper_shell(false);
    const auto model = ReferenceModel::build(mesh, {});
    ASSERT_TRUE(model);
    RayCaster caster;
    caster.add(mesh);
    caster.commit();
    std::mt19937 random(5);
    const MeshBounds b = bounds_of(mesh);
    std::uniform_real_distribution<float> share(-0.3F, 1.3F);
    for (int i = 0; i < 3000; ++i) {
        const Eigen::Vector3f p =
            b.min + Eigen::Vector3f(share(random), share(random), share(random)).cwiseProduct(b.max - b.min);
        const auto nearest = caster.nearest(p, 0.4F);
        const float exact = nearest ? std::min(nearest->distance, 0.15F) : 0.15F;
        EXPECT_NEAR((*model)->distance_to_surface(p), exact, 0.012F);
    }
    EXPECT_FLOAT_EQ((*model)->distance_to_surface({50, 0, 0}), 0.15F);
    EXPECT_FLOAT_EQ((*model)->distance_to_surface({std::nanf(""), 0, 0}), 0.15F);
}

TEST(ReferenceModel, SameMeshSameModel) {
    const SurfaceMesh mesh = bumper_shell(true);
    ReferenceModelParams params;
    params.fine_spacing = 0.025;
    const auto one = ReferenceModel::build(mesh, params), two = ReferenceModel::build(mesh, params);
    ASSERT_TRUE(one && two);
    EXPECT_EQ((*one)->descriptors(), (*two)->descriptors());
    ASSERT_EQ((*one)->fine().size(), (*two)->fine().size());
    for (size_t i = 0; i < (*one)->fine().size(); ++i) {
        EXPECT_EQ((*one)->fine()[i].position, (*two)->fine()[i].position);
        EXPECT_EQ((*one)->fine()[i].visible_from, (*two)->fine()[i].visible_from);
    }
}

TEST(ReferenceModel, RefusesWhatShowsNoSurface) {
    EXPECT_EQ(ReferenceModel::build({}, {}).error().sentence, "the part's mesh is empty.");
    const SurfaceMesh speck{{{0, 0, 0}, {0.001F, 0, 0}, {0, 0.001F, 0}}, {{0, 1, 2}}};
    EXPECT_EQ(ReferenceModel::build(speck, {}).error().sentence,
              "the part's mesh shows too little surface to the outside to be recognised.");
}

TEST(ReferenceModel, WidensItsSpacingForHugeParts) {
    const auto model = ReferenceModel::build(box({0, 0, 0}, {18, 12, 6}), {});
    ASSERT_TRUE(model) << model.error().sentence;
    EXPECT_LT((*model)->fine().size(), 120'000U);
    EXPECT_GT((*model)->params().fine_spacing, 0.05);
    EXPECT_LT((*model)->distance_to_surface({9, 6, 6}), 0.1F);
}

TEST(ReferenceModel, NamesEverySettingOutOfRange) {
    ReferenceModelParams params;
    EXPECT_TRUE(params.validate().empty());
    params.fine_spacing = 0;
    params.coarse_spacing = -1;
    params.descriptor_radius = 9;
    params.grid_cell = 5;
    params.reach = std::nan("");
    std::vector<std::string> keys;
    for (const InvalidSetting& s : params.validate()) keys.push_back(s.key);
    EXPECT_EQ(keys, (std::vector<std::string>{"fine_spacing", "coarse_spacing", "descriptor_radius",
                                              "grid_cell", "reach"}));
}

}  // namespace
}  // namespace deixis
