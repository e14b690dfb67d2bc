// Figures against hand-counted ones, criteria met and not met, and both forms of the report.
#include "appliance/acceptance/acceptance_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <sstream>

namespace deixis {
namespace {

Truth truth_in(const std::string& text) {
    std::istringstream in(text);
    return read_truth(in, "truth").value();
}

Results results_in(const std::string& text) {
    std::istringstream in(text);
    return read_results(in, "results").value();
}

const char* const upright = "\"rotation\": [[1,0,0],[0,1,0],[0,0,1]]";

/// Two frames of truth with a meant gesture at the spot (0, 0, 0), part at the origin.
Truth one_gesture() {
    const std::string line = std::string("\"part\": {") + upright +
                             ", \"translation\": [0,0,0]}, \"pointing\": {\"hold\": 1, \"meant\": true, "
                             "\"arm\": \"left\", \"target_part\": [0,0,0]}}\n";
    return truth_in("{\"timestamp_us\": 0, " + line + "{\"timestamp_us\": 33333, " + line);
}

/// A mark 50 mm off in the first frame; the part 3 mm off, then turned by 90 degrees.
Results one_mark() {
    return results_in(
        std::string("{\"timestamp_us\": 0, \"part\": {\"state\": \"tracking\", ") + upright +
        ", \"translation\": [0.003,0,0]}, \"pointing\": {\"arm\": \"left\"}, \"marks\": [{\"id\": 1, "
        "\"position_part\": [0,0.05,0]}], \"stage_ms\": {\"total\": 10}}\n"
        "{\"timestamp_us\": 33333, \"part\": {\"state\": \"tracking\", \"rotation\": "
        "[[0,-1,0],[1,0,0],[0,0,1]], "
        "\"translation\": [0,0,0]}, \"stage_ms\": {\"total\": 20}}\n"
        "{\"timestamp_us\": 900000, \"part\": {\"state\": \"lost\"}, \"stage_ms\": {\"total\": 30}}\n");
}

TEST(SampleSummary, IsTheNearestRank) {
    std::vector<double> samples(100);
    std::iota(samples.begin(), samples.end(), 1);
    const SampleSummary summary = summarise(samples);
    EXPECT_EQ(summary.median, 50);
    EXPECT_EQ(summary.p95, 95);
    EXPECT_EQ(summary.p99, 99);
    EXPECT_EQ(summary.max, 100);
    EXPECT_EQ(summarise({7}).p95, 7);
    EXPECT_EQ(summarise({}).count, 0U);
}

TEST(AcceptanceReport, CountsWhatAPersonWouldCount) {
    const Box box{Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1)};
    const AcceptanceReport report = judge_session(one_gesture(), one_mark(), {}, box);
    EXPECT_TRUE(report.failures.empty()) << testing::PrintToString(report.failures);
    EXPECT_NEAR(report.position_mm.median, 50, 1e-9);
    EXPECT_EQ(report.arms_right, 1U);
    EXPECT_EQ(report.part.frames_with_truth, 2U);
    EXPECT_EQ(report.part.frames_tracking, 2U);
    EXPECT_NEAR(report.part.origin_mm.max, 3, 1e-9);
    EXPECT_NEAR(report.part.rotation_deg.max, 90, 1e-6);
    EXPECT_NEAR(report.part.corner_mm.max, 2000, 1e-6)
        << "each corner turns by 90 degrees at 1.414 m from the axis";
    EXPECT_NEAR(report.part.corner_mm.median, 3, 1e-9);
    EXPECT_EQ(report.frame_ms.p99, 30);
}

TEST(AcceptanceReport, WithoutCriteriaEveryMarkIsDemanded) {
    Results nothing = one_mark();
    nothing.frames[0].marks.clear();
    const AcceptanceReport report = judge_session(one_gesture(), nothing, {}, std::nullopt);
    EXPECT_THAT(report.failures,
                testing::ElementsAre("0 of 1 meant gestures are exactly one mark in its place"));
}

TEST(AcceptanceReport, EveryCriterionThatIsNotMetIsOneSentence) {
    Expected expected;
    expected.marks_found_min = 1.0;
    expected.false_marks_max = 0;
    expected.position_mm_median_max = 49;
    expected.part_mm_max = 2.5;
    expected.part_deg_max = 1;
    expected.frame_ms_p99_max = 29;
    expected.pcp_min = 0.5;
    const AcceptanceReport report = judge_session(one_gesture(), one_mark(), {expected, false}, std::nullopt);
    EXPECT_THAT(report.failures, testing::ElementsAre("position_mm_median_max is 50.00, allowed 49.00",
                                                      "pcp_min cannot be judged: there is no data for it",
                                                      "part_mm_max is 3.00, allowed 2.50",
                                                      "part_deg_max is 90.00, allowed 1.00",
                                                      "frame_ms_p99_max is 30.00, allowed 29.00"));
}

TEST(AcceptanceReport, CriteriaWithoutDataFail) {
    Expected expected;
    expected.marks_found_min = 0.5;
    expected.part_mm_max = 10;
    const AcceptanceReport report =
        judge_session(truth_in("{\"timestamp_us\": 0}"), results_in("{\"timestamp_us\": 0}"),
                      {expected, false}, std::nullopt);
    EXPECT_THAT(report.failures,
                testing::ElementsAre("marks_found_min cannot be judged: there is no data for it",
                                     "part_mm_max cannot be judged: there is no data for it"));
}

TEST(AcceptanceReport, TableAndJsonSayTheSame) {
    const AcceptanceReport report = judge_session(one_gesture(), one_mark(), {}, std::nullopt);
    const std::string table = table_of(report);
    EXPECT_THAT(table,
                testing::HasSubstr("meant gestures   1: 1 right, 0 missed, 0 doubled, 0 too far; traps 0\n"));
    EXPECT_THAT(table, testing::HasSubstr("accepted\n"));
    const nlohmann::ordered_json figures = to_json(report);
    EXPECT_EQ(figures["right"], 1);
    EXPECT_EQ(figures["accepted"], true);
    EXPECT_EQ(figures["holds"][0]["verdict"], "right");
    EXPECT_EQ(figures["part"]["corner_mm"]["count"], 0) << "no box was given";
}

}  // namespace
}  // namespace deixis
