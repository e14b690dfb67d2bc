// The sample bumpers: size, thin wall, outer skin towards -y, no mirror symmetry, the same on every run.
#include "appliance/parts/sample_bumper.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "appliance/parts/model_file.h"
#include "tracking/geometry/ray_caster.h"

namespace deixis {
namespace {

SurfaceMesh fresh_bumper(SampleBumper variant) {
    const auto file =
        std::filesystem::temp_directory_path() / ("deixis-bumper-" + std::to_string(::getpid()) + ".step");
    const auto done = write_sample_bumper(variant, file);
    EXPECT_TRUE(done) << done.error().sentence;
    std::ifstream in(file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_NE(text.find("'2024-01-01T00:00:00'"), std::string::npos)
        << "no wall clock: the same bytes every time";
    auto mesh = read_model_file(file, 0.001);
    EXPECT_TRUE(mesh) << mesh.error().sentence;
    std::filesystem::remove(file);
    return mesh ? *mesh : SurfaceMesh{};
}

/// Made once for all tests: the solid modelling takes seconds.
const SurfaceMesh& bumper(SampleBumper variant) {
    static const SurfaceMesh a = fresh_bumper(SampleBumper::a), b = fresh_bumper(SampleBumper::b);
    return variant == SampleBumper::a ? a : b;
}

double volume_of(const SurfaceMesh& mesh) {
    double six = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        six += mesh.vertices[a].cast<double>().dot(
            mesh.vertices[b].cast<double>().cross(mesh.vertices[c].cast<double>()));
    return six / 6;
}

TEST(SampleBumper, IsAThinClosedShellOfBumperSize) {
    for (const SampleBumper variant : {SampleBumper::a, SampleBumper::b}) {
        const SurfaceMesh& mesh = bumper(variant);
        ASSERT_FALSE(mesh.vertices.empty());
        const Eigen::Vector3f size = bounds_of(mesh).max - bounds_of(mesh).min;
        EXPECT_NEAR(size.x(), 1.68, 0.12);
        EXPECT_GT(size.y(), 0.3F);
        EXPECT_NEAR(size.z(), 0.42, 0.05);
        // Outward winding makes the volume positive; over half the mesh's area it gives the wall's thickness.
        double area = 0;
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            area +=
                0.5 *
                static_cast<double>(
                    (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm());
        }
        EXPECT_NEAR(volume_of(mesh) / (area / 2), 0.003, 0.0003);
    }
}

TEST(SampleBumper, SkinFacesMinusYWithWallAndHoles) {
    const SurfaceMesh& mesh = bumper(SampleBumper::a);
    RayCaster caster;
    caster.add(mesh);
    caster.commit();
    const auto front = caster.cast({0.3F, -1, 0.27F}, {0, 1, 0});
    ASSERT_TRUE(front);
    EXPECT_LT(front->normal.y(), -0.8F);
    const auto wall = caster.cast({0.3F, -1, 0.27F}, {0, 1, 0}, front->distance + 1e-4F);
    ASSERT_TRUE(wall);
    EXPECT_NEAR(wall->distance - front->distance, 0.003, 0.0005);
    const float x = 2.5F * std::sin(6.5F * 3.14159265F / 180);
    const Eigen::Vector3f into(-std::sin(6.5F * 3.14159265F / 180), std::cos(6.5F * 3.14159265F / 180), 0);
    EXPECT_FALSE(caster.cast(Eigen::Vector3f(x, 0.0160F, 0.262F) - into, into)) << "a sensor hole";
}

TEST(SampleBumper, EndsDiffer) {
    for (const SampleBumper variant : {SampleBumper::a, SampleBumper::b}) {
        const SurfaceMesh& mesh = bumper(variant);
        RayCaster caster;
        caster.add(mesh);
        caster.commit();
        int unlike = 0, all = 0;
        for (float x = 0.02F; x < 0.75F; x += 0.01F)
            for (float z = 0; z < 0.4F; z += 0.01F) {
                const auto right = caster.cast({x, -1, z}, {0, 1, 0}),
                           left = caster.cast({-x, -1, z}, {0, 1, 0});
                ++all;
                if (right.has_value() != left.has_value() ||
                    (right && std::abs(right->distance - left->distance) > 0.01F))
                    ++unlike;
            }
        EXPECT_GT(unlike, all / 50);
    }
}

TEST(SampleBumper, SameGeometryEveryTime) {
    const SurfaceMesh &one = bumper(SampleBumper::b), two = fresh_bumper(SampleBumper::b);
    ASSERT_EQ(one.vertices.size(), two.vertices.size());
    EXPECT_TRUE(std::equal(one.vertices.begin(), one.vertices.end(), two.vertices.begin()));
    EXPECT_EQ(one.triangles, two.triangles);
}

TEST(SampleBumper, RefusesAFolderThatIsNotThere) {
    const auto done = write_sample_bumper(SampleBumper::a, "/nowhere/at/all.step");
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().sentence, "/nowhere/at/all.step: the STEP file cannot be written there.");
}

}  // namespace
}  // namespace deixis
