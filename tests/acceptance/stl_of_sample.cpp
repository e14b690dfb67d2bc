// stl_of_sample STEP OUT.stl: a model file of ours as binary STL in millimetres, the way a body shop would
// send one.
#include <cstdint>
#include <fstream>
#include <iostream>

#include "appliance/parts/model_file.h"

namespace {

void put(std::ofstream& out, const Eigen::Vector3f& v) {
    out.write(reinterpret_cast<const char*>(v.data()), 3 * sizeof(float));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::cerr << "usage: stl_of_sample MODEL.step OUT.stl\n";
        return 2;
    }
    const auto mesh = deixis::read_model_file(argv[1], 0.001);
    if (!mesh) {
        std::cerr << mesh.error().sentence << '\n';
        return 1;
    }
    std::ofstream out(argv[2], std::ios::binary);
    out << std::string(80, ' ');
    const auto count = static_cast<uint32_t>(mesh->triangles.size());
    out.write(reinterpret_cast<const char*>(&count), sizeof count);
    for (size_t t = 0; t < mesh->triangles.size(); ++t) {
        put(out, deixis::triangle_normal(*mesh, t));
        for (const uint32_t index : mesh->triangles[t]) put(out, mesh->vertices[index] * 1000.0F);
        out.write("\0\0", 2);
    }
    return out.flush() ? 0 : 1;
}
