// results.jsonl, judged against a small truth.
#include <sstream>

#include "appliance/acceptance/acceptance_report.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    std::istringstream in{std::string(deixis::as_text(data, size))};
    const auto results = deixis::read_results(in, "results.jsonl");
    deixis::expect_value_or_sentence(results);
    if (!results) return 0;
    deixis::Truth truth;
    truth.frames.emplace_back();
    truth.frames.back().part_translation = Eigen::Vector3d::Zero();
    truth.frames.back().pointing = deixis::TruthPointing{1, {}, true, {}, Eigen::Vector3d::Zero()};
    const auto report = deixis::judge_session(truth, *results, {}, deixis::Box{});
    deixis::table_of(report);
    deixis::to_json(report).dump();
    return 0;
}
