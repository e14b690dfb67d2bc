// calibration.toml; what is read can be written and read again as the same text.
#include <cstdlib>

#include "appliance/calibration/calibration_file.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const auto file = deixis::parse_calibration(deixis::as_text(data, size), "calibration.toml");
    deixis::expect_value_or_sentence(file);
    if (!file) return 0;
    const std::string text = deixis::calibration_text(file->rig);
    const auto again = deixis::parse_calibration(text, "calibration.toml");
    if (!again || deixis::calibration_text(again->rig) != text) std::abort();
    return 0;
}
