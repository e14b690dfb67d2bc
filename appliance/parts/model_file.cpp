// A part's model file of any supported kind as checked triangles in metres: CAD through Open CASCADE, meshes
// through Assimp.
#include "appliance/parts/model_file.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "appliance/parts/cad_file.h"
#include "appliance/parts/ply_check.h"

namespace Assimp {

/// Debian's Assimp 5.2 calls this where it doubts itself; its own version ends the program, and there is no
/// setter. This one takes its place when the program is linked: a damaged file must not be able to stop a
/// station.
// NOLINTNEXTLINE(readability-identifier-naming): the name is Assimp's
[[noreturn]] void aiAssertViolation(const char* doubt, const char* /*file*/, int /*line*/);
void aiAssertViolation(const char* doubt, const char* /*file*/, int /*line*/) {
    throw std::runtime_error(std::string("inner check failed: ") + doubt);
}

}  // namespace Assimp

namespace deixis {
namespace {

constexpr double smallest_part = 0.01, largest_part = 20;      // [m]
constexpr std::uintmax_t largest_file = 512ULL * 1024 * 1024;  // [byte]

std::string lower_extension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

void append_assimp_mesh(SurfaceMesh& mesh, const aiMesh& part) {
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (unsigned i = 0; i < part.mNumVertices; ++i)
        mesh.vertices.emplace_back(part.mVertices[i].x, part.mVertices[i].y, part.mVertices[i].z);
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
        const aiFace& face = part.mFaces[i];
        if (face.mNumIndices != 3) continue;  // points and lines of an OBJ are not surface
        const auto a = face.mIndices[0], b = face.mIndices[1], c = face.mIndices[2];
        if (std::max({a, b, c}) < part.mNumVertices)
            mesh.triangles.push_back({first + a, first + b, first + c});
    }
}

/// The file's own numbers, without axis flips: the three formats have no scene graph worth obeying.
Result<SurfaceMesh> read_mesh_file(const std::filesystem::path& file) {
    try {
        Assimp::Importer importer;
        importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
        const aiScene* scene =
            importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices);
        if (scene == nullptr)
            return fail(file.string() + ": the mesh cannot be read (" + importer.GetErrorString() + ").");
        SurfaceMesh mesh;
        for (unsigned i = 0; i < scene->mNumMeshes; ++i) append_assimp_mesh(mesh, *scene->mMeshes[i]);
        return mesh;
    } catch (const std::exception& failure) {
        return fail(file.string() + ": the mesh cannot be read (" + failure.what() + ").");
    }
}

double longest_side(const SurfaceMesh& mesh) {
    const MeshBounds bounds = bounds_of(mesh);
    return static_cast<double>((bounds.max - bounds.min).maxCoeff());
}

void scale(SurfaceMesh& mesh, double factor) {
    for (auto& v : mesh.vertices) v = (v.cast<double>() * factor).cast<float>();
}

std::string length_text(double metres) {
    char text[64];
    if (metres >= 0.1)
        std::snprintf(text, sizeof text, "%.4g m", metres);
    else
        std::snprintf(text, sizeof text, "%.4g mm", metres * 1e3);
    return text;
}

}  // namespace

Result<SurfaceMesh> checked_mesh(SurfaceMesh mesh, const std::filesystem::path& model) {
    const std::string name = model.string();
    if (mesh.triangles.empty()) return fail(name + ": the file holds no triangle, expected a surface.");
    if (mesh.triangles.size() > most_triangles)
        return fail(name + ": the file holds " + std::to_string(mesh.triangles.size()) +
                    " triangles, expected at most " + std::to_string(most_triangles) + ".");
    if (mesh.vertices.size() > most_vertices)
        return fail(name + ": the file holds " + std::to_string(mesh.vertices.size()) +
                    " vertices, expected at most " + std::to_string(most_vertices) + ".");
    for (const auto& [a, b, c] : mesh.triangles)
        if (std::max({a, b, c}) >= mesh.vertices.size())
            return fail(name + ": a triangle has a corner " + std::to_string(std::max({a, b, c})) + " of " +
                        std::to_string(mesh.vertices.size()) + " vertices.");
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        if (!mesh.vertices[i].allFinite())
            return fail(name + ": vertex " + std::to_string(i) + " is not a finite number.");
    const double size = longest_side(mesh);
    if (!(size >= smallest_part && size <= largest_part))
        return fail(name + ": the part would be " + length_text(size) +
                    " long, expected 1 cm to 20 m; check `units` in part.toml.");
    return mesh;
}

Result<SurfaceMesh> read_model_file(const std::filesystem::path& model, double metres_per_unit) {
    const std::string name = model.string(), extension = lower_extension(model);
    const bool step = extension == ".step" || extension == ".stp",
               iges = extension == ".iges" || extension == ".igs";
    const bool mesh_format = extension == ".stl" || extension == ".obj" || extension == ".ply";
    if (!step && !iges && !mesh_format)
        return fail(name + ": unknown kind of model \"" + extension +
                    "\", expected STEP, IGES, STL, OBJ or PLY.");
    if (!(metres_per_unit > 0) || !std::isfinite(metres_per_unit))
        return fail(name + ": the unit must be a positive length, got " + std::to_string(metres_per_unit) +
                    " m.");
    std::error_code error;
    if (!std::filesystem::is_regular_file(model, error)) return fail(name + ": there is no such model file.");
    const std::uintmax_t bytes = std::filesystem::file_size(model, error);
    if (error || bytes == 0) return fail(name + ": the model file is empty.");
    if (bytes > largest_file) return fail(name + ": the model file is larger than 512 MB.");

    if (extension == ".ply") {
        std::ifstream in(model, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        if (const auto sound = check_ply(text, name); !sound) return tl::unexpected(sound.error());
    }
    if (mesh_format) {
        Result<SurfaceMesh> mesh = read_mesh_file(model);
        if (!mesh) return mesh;
        scale(*mesh, metres_per_unit);
        return checked_mesh(std::move(*mesh), model);
    }
    Result<SurfaceMesh> mesh = read_cad_file(model, iges);
    if (!mesh) return mesh;
    // A CAD file states its own unit, and that holds. Only where it gives an impossible part is the file
    // taken to state the wrong one (metres written as millimetres and the reverse), and part.toml's word is
    // used.
    const double size = longest_side(*mesh);
    if (size < smallest_part && metres_per_unit == 1) scale(*mesh, 1e3);
    if (size > largest_part && metres_per_unit == 1e-3) scale(*mesh, 1e-3);
    return checked_mesh(std::move(*mesh), model);
}

}  // namespace deixis
