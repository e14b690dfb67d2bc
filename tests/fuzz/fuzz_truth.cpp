// truth.jsonl, through to the gestures and part poses that are made of it.
#include <cstdlib>
#include <sstream>

#include "appliance/acceptance/mark_matching.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    std::istringstream in{std::string(deixis::as_text(data, size))};
    const auto truth = deixis::read_truth(in, "truth.jsonl");
    deixis::expect_value_or_sentence(truth);
    if (!truth) return 0;
    deixis::match_marks(*truth, {});
    for (const deixis::TruthFrame& frame : truth->frames) deixis::part_pose_at(*truth, frame.timestamp_us);
    return 0;
}
