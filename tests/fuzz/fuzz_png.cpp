// PNG images as depth, infrared and video, of a size that is known before.
#include "appliance/sessions/depth_png.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    // The size that the file claims, when it is small; else one that it does not have.
    deixis::ImageSize expected = {8, 6};
    if (size > 24 && data[16] == 0 && data[17] == 0 && data[18] == 0) expected.width = data[19];
    if (size > 24 && data[20] == 0 && data[21] == 0 && data[22] == 0) expected.height = data[23];
    const std::span<const uint8_t> file(data, size);
    deixis::expect_value_or_sentence(deixis::decode_depth_png(file, "fuzz.png", expected));
    deixis::expect_value_or_sentence(deixis::decode_infrared_png(file, "fuzz.png", expected));
    deixis::expect_value_or_sentence(deixis::decode_video_png(file, "fuzz.png", expected));
    return 0;
}
