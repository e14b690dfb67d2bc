// .oni recordings: walked, read and mended; what the walk lets pass has the frames that it counts.
#include <cstdlib>

#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/oni_writer.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string name = "fuzz.oni";
    int64_t frames = 0;
    const auto read =
        deixis::read_oni({data, size}, name, [&](int64_t, int64_t, const deixis::DepthImage& image) {
            ++frames;
            return image.millimetres.size() ==
                   static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
        });
    deixis::expect_value_or_sentence(read);
    if (read && read->frames != frames) std::abort();
    deixis::expect_value_or_sentence(deixis::walk_oni({data, size}, name, deixis::OniPixels::skipped));
    // Mending waits for the disk, so only a share of the inputs goes that way.
    if (read || size % 16 != 0) return 0;
    const std::filesystem::path path = deixis::input_as_file(data, size, ".oni");
    const auto mended = deixis::mend_recording(path);
    deixis::expect_value_or_sentence(mended);
    if (!mended) return 0;
    const auto walked = deixis::walk_oni(path);
    if (!walked || walked->frames != mended->frames) std::abort();
    return 0;
}
