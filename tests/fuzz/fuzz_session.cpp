// session.toml.
#include "appliance/sessions/session.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    deixis::expect_value_or_sentence(deixis::parse_session(deixis::as_text(data, size), "session.toml"));
    return 0;
}
