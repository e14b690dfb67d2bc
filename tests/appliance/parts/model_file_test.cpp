// Model files of every kind: the same tetrahedron in, the same triangles out; and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <BRepPrimAPI_MakeBox.hxx>
#include <Eigen/Geometry>
#include <IGESControl_Writer.hxx>
#include <STEPControl_Writer.hxx>
#include <TopoDS_Shape.hxx>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "appliance/parts/model_file.h"

namespace deixis {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class ModelFileTest : public testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            std::filesystem::temp_directory_path() / ("deixis-model-file-" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path written(const std::string& name, const std::string& bytes) {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
        return folder_ / name;
    }
    std::string refusal(const std::string& name, const std::string& bytes, double unit = 0.001) {
        const auto mesh = read_model_file(written(name, bytes), unit);
        return mesh ? "accepted" : mesh.error().sentence;
    }

    std::filesystem::path folder_;
};

/// A binary STL of one triangle; `count` is what its header claims.
std::string binary_stl(const float (&corner)[9], uint32_t count = 1) {
    std::string bytes(80, ' ');
    const auto put = [&](const void* data, size_t size) {
        bytes.append(static_cast<const char*>(data), size);
    };
    const float normal[3] = {0, 0, 1};
    const uint16_t attribute = 0;
    put(&count, 4);
    put(normal, sizeof normal);
    put(corner, sizeof corner);
    put(&attribute, 2);
    return bytes;
}

const std::string ply_head =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
const std::string ply =
    ply_head + "0 0 0\n1000 0 0\n0 1000 0\n0 0 1000\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
const std::string obj = "v 0 0 0\nv 1000 0 0\nv 0 1000 0\nv 0 0 1000\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
const std::string stl =
    "solid t\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1000 0\nvertex 1000 0 "
    "0\nendloop\nendfacet\n"
    "facet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex 1000 0 0\nvertex 0 0 1000\nendloop\nendfacet\n"
    "endsolid t\n";

void expect_metre_corner(const SurfaceMesh& mesh) {
    const MeshBounds bounds = bounds_of(mesh);
    EXPECT_LT((bounds.min - Eigen::Vector3f(0, 0, 0)).norm(), 1e-6);
    EXPECT_LT((bounds.max - Eigen::Vector3f(1, 1, 1)).norm(), 1e-6);
}

TEST_F(ModelFileTest, MeshFormatsKeepAxesAndObeyUnits) {
    for (const auto& [name, text] :
         {std::pair{"t.ply", ply}, {"t.obj", obj}, {"t.stl", stl}, {"T.STL", stl}}) {
        const auto mesh = read_model_file(written(name, text), 0.001);
        ASSERT_TRUE(mesh) << mesh.error().sentence;
        expect_metre_corner(*mesh);
    }
    const auto large = read_model_file(folder_ / "t.ply", 0.01);
    ASSERT_TRUE(large);
    EXPECT_NEAR(bounds_of(*large).max.x(), 10, 1e-5);
    EXPECT_EQ(large->triangles.size(), 4U);
}

TEST_F(ModelFileTest, PolygonsBecomeTrianglesAndGroupsAreJoined) {
    const auto mesh = read_model_file(
        written(
            "q.obj",
            "o a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\no b\nv 0 0 1\nv 1 0 1\nv 1 1 1\nf 5 6 7\n"),
        1);
    ASSERT_TRUE(mesh) << mesh.error().sentence;
    EXPECT_EQ(mesh->triangles.size(), 3U);
    const auto mixed =
        read_model_file(written("m.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nl 1 3\np 2\nf 1 2 3 4\n"), 1);
    ASSERT_TRUE(mixed) << mixed.error().sentence;
    EXPECT_EQ(mixed->triangles.size(), 2U) << "lines and points are left out";
    EXPECT_NEAR(bounds_of(*mesh).max.z(), 1, 1e-6);
}

/// A STEP or IGES file of a box of 1700 x 600 x 400 mm with its corner at the origin.
std::filesystem::path box_file(const std::filesystem::path& file) {
    const TopoDS_Shape box = BRepPrimAPI_MakeBox(1700, 600, 400).Shape();
    if (file.extension() == ".igs") {
        IGESControl_Writer writer("MM", 1);
        writer.AddShape(box);
        writer.Write(file.c_str());
    } else {
        STEPControl_Writer writer;
        writer.Transfer(box, STEPControl_AsIs);
        writer.Write(file.c_str());
    }
    return file;
}

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

void expect_box(const Result<SurfaceMesh>& mesh) {
    ASSERT_TRUE(mesh) << mesh.error().sentence;
    const MeshBounds bounds = bounds_of(*mesh);
    EXPECT_LT(bounds.min.norm(), 1e-5);
    EXPECT_LT((bounds.max - Eigen::Vector3f(1.7F, 0.6F, 0.4F)).norm(), 1e-5);
    // Wound outwards: the divergence theorem gives the volume with a positive sign.
    double six = 0;
    for (const auto& [a, b, c] : mesh->triangles)
        six += static_cast<double>(mesh->vertices[a].dot(mesh->vertices[b].cross(mesh->vertices[c])));
    EXPECT_NEAR(six / 6, 1.7 * 0.6 * 0.4, 1e-5);
}

TEST_F(ModelFileTest, CadFilesCarryTheirOwnUnit) {
    testing::internal::CaptureStdout();
    const auto step = box_file(folder_ / "b.step"), iges = box_file(folder_ / "b.igs");
    testing::internal::GetCapturedStdout();
    for (const double unit : {0.001, 1.0}) {
        expect_box(read_model_file(step, unit));
        expect_box(read_model_file(iges, unit));
    }
    // The same numbers, declared as metres by the file: 1.7 km by its own word, 1.7 m by part.toml's.
    std::string text = text_of(step);
    size_t at = 0;
    while ((at = text.find("SI_UNIT(.MILLI.,.METRE.)", at)) != std::string::npos)
        text.replace(at, 24, "SI_UNIT($,.METRE.)");
    const auto in_metres = written("metres.STP", text);
    expect_box(read_model_file(in_metres, 0.001));
    const auto huge = read_model_file(in_metres, 1);
    ASSERT_FALSE(huge);
    EXPECT_EQ(huge.error().sentence,
              in_metres.string() +
                  ": the part would be 1700 m long, expected 1 cm to 20 m; check `units` in part.toml.");
}

TEST_F(ModelFileTest, RefusesFilesThatAreNotThere) {
    const std::string stem = folder_.string() + "/";
    EXPECT_EQ(read_model_file(stem + "none.stl", 0.001).error().sentence,
              stem + "none.stl: there is no such model file.");
    EXPECT_EQ(read_model_file(stem + "none.step", 0.001).error().sentence,
              stem + "none.step: there is no such model file.");
    EXPECT_EQ(read_model_file(folder_, 0.001).error().sentence,
              folder_.string() + ": unknown kind of model \"\", expected STEP, IGES, STL, OBJ or PLY.");
    EXPECT_EQ(refusal("x.fbx", "abc"),
              stem + "x.fbx: unknown kind of model \".fbx\", expected STEP, IGES, STL, OBJ or PLY.");
    EXPECT_EQ(refusal("e.stl", ""), stem + "e.stl: the model file is empty.");
    EXPECT_EQ(refusal("e.step", ""), stem + "e.step: the model file is empty.");
    EXPECT_EQ(refusal("u.ply", ply, 0), stem + "u.ply: the unit must be a positive length, got 0.000000 m.");
    EXPECT_EQ(refusal("u.ply", ply, std::numeric_limits<double>::quiet_NaN()),
              stem + "u.ply: the unit must be a positive length, got nan m.");
}

TEST_F(ModelFileTest, RefusesDamagedMeshes) {
    const std::string stem = folder_.string() + "/";
    const float good[9] = {0, 0, 0, 100, 0, 0, 0, 100, 0};
    const float broken[9] = {0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0, 100, 0};
    const float endless[9] = {0, 0, 0, std::numeric_limits<float>::infinity(), 0, 0, 0, 100, 0};
    EXPECT_EQ(refusal("good.stl", binary_stl(good)), "accepted");
    EXPECT_THAT(refusal("short.stl", binary_stl(good).substr(0, 100)),
                StartsWith(stem + "short.stl: the mesh cannot be read ("));
    EXPECT_THAT(refusal("head.stl", binary_stl(good).substr(0, 40)),
                StartsWith(stem + "head.stl: the mesh cannot be read ("));
    EXPECT_THAT(refusal("many.stl", binary_stl(good, 4'000'000'000U)),
                StartsWith(stem + "many.stl: the mesh cannot be read ("));
    EXPECT_THAT(refusal("nan.stl", binary_stl(broken)),
                AllOf(StartsWith(stem + "nan.stl: vertex "), HasSubstr("is not a finite number.")));
    EXPECT_THAT(refusal("inf.stl", binary_stl(endless)),
                AllOf(StartsWith(stem + "inf.stl: vertex "), HasSubstr("is not a finite number.")));
    EXPECT_THAT(refusal("garbage.stl", std::string(500, '\x7f')),
                StartsWith(stem + "garbage.stl: the mesh cannot be read ("));
    EXPECT_THAT(refusal("garbage.ply", "no ply at all"),
                StartsWith(stem + "garbage.ply: the mesh cannot be read ("));
    EXPECT_THAT(refusal("cut.ply", ply_head + "0 0 0\n"), StartsWith(stem + "cut.ply: "));
    EXPECT_THAT(refusal("huge.ply",
                        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
                        "property float y\nproperty float z\nend_header\nabc"),
                StartsWith(stem + "huge.ply: "));
    EXPECT_THAT(refusal("cloud.ply",
                        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                        "property float z\nend_header\n1 2 3\n"),
                StartsWith(stem + "cloud.ply: "));
    EXPECT_THAT(refusal("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), StartsWith(stem + "points.obj: "));
    EXPECT_THAT(refusal("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
                StartsWith(stem + "index.obj: "));
    EXPECT_EQ(
        refusal("flat.obj", "v 5 5 5\nv 5 5 5\nv 5 5 5\nf 1 2 3\n"),
        stem + "flat.obj: the part would be 0 mm long, expected 1 cm to 20 m; check `units` in part.toml.");
}

TEST_F(ModelFileTest, RefusesImpossibleSizes) {
    const std::string stem = folder_.string() + "/";
    EXPECT_EQ(
        refusal("km.ply", ply, 1),
        stem + "km.ply: the part would be 1000 m long, expected 1 cm to 20 m; check `units` in part.toml.");
    EXPECT_EQ(
        refusal("mm.obj", "v 0 0 0\nv 1.7 0 0\nv 0 1 0\nf 1 2 3\n"),
        stem + "mm.obj: the part would be 1.7 mm long, expected 1 cm to 20 m; check `units` in part.toml.");
}

TEST_F(ModelFileTest, RefusesDamagedCadFilesInSilence) {
    const std::string stem = folder_.string() + "/";
    testing::internal::CaptureStdout();
    const std::string whole = text_of(box_file(folder_ / "whole.step"));
    testing::internal::GetCapturedStdout();
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_EQ(refusal("g.step", "this is no STEP file"), stem + "g.step: this is not a readable STEP file.");
    EXPECT_EQ(refusal("g.stp", std::string(3000, '\0')), stem + "g.stp: this is not a readable STEP file.");
    EXPECT_THAT(refusal("h.step", "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"),
                StartsWith(stem + "h.step: "));
    EXPECT_THAT(refusal("g.iges", "this is no IGES file"), StartsWith(stem + "g.iges: "));
    EXPECT_THAT(refusal("g.igs", std::string(800, 'S')), StartsWith(stem + "g.igs: "));
    EXPECT_THAT(refusal("half.step", whole.substr(0, whole.size() / 2)), StartsWith(stem + "half.step: "));
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace deixis
