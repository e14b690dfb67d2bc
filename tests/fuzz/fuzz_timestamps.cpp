// timestamps.csv; what is read rises, and can be written and read again.
#include <cstdlib>

#include "appliance/sessions/frame_stamps.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const auto stamps = deixis::parse_timestamps(deixis::as_text(data, size), "timestamps.csv");
    deixis::expect_value_or_sentence(stamps);
    if (!stamps) return 0;
    for (size_t i = 1; i < stamps->timestamp_us.size(); ++i)
        if (stamps->timestamp_us[i] <= stamps->timestamp_us[i - 1]) std::abort();
    const auto again = deixis::parse_timestamps(deixis::timestamps_text(*stamps), "timestamps.csv");
    if (!again || again->timestamp_us != stamps->timestamp_us || again->host_us != stamps->host_us)
        std::abort();
    return 0;
}
