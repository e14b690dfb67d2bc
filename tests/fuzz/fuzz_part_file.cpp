// part.toml.
#include "appliance/parts/part_model.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const auto part = deixis::read_part_file(deixis::input_as_file(data, size, ".toml"));
    deixis::expect_value_or_sentence(part);
    if (part) deixis::zone_of(part->zones, {0.1, 0.2, 0.3});
    return 0;
}
