// settings.toml.
#include "appliance/station/settings.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    deixis::expect_value_or_sentence(deixis::parse_settings(deixis::as_text(data, size), "settings.toml"));
    return 0;
}
