// expected.toml.
#include "appliance/acceptance/expected_file.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    deixis::expect_value_or_sentence(deixis::read_expected(deixis::input_as_file(data, size, ".toml")));
    return 0;
}
