// Model files; one program a format, which differ in the file's ending.
#include "appliance/parts/model_file.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const auto mesh = deixis::read_model_file(deixis::input_as_file(data, size, FUZZ_ENDING), 0.001);
    deixis::expect_value_or_sentence(mesh);
    if (mesh && (mesh->triangles.empty() || mesh->vertices.empty())) std::abort();
    return 0;
}
