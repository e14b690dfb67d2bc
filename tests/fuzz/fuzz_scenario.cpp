// Scenario files.
#include "appliance/simulation/scenario.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string text(deixis::as_text(data, size));
    deixis::expect_value_or_sentence(deixis::parse_scenario(text, "scenario.toml"));
    return 0;
}
