// results.jsonl: what is read and what is refused with which sentence.
#include "appliance/acceptance/results_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace deixis {
namespace {

Result<Results> results_of(const std::string& text) {
    std::istringstream in(text);
    return read_results(in, "results.jsonl");
}

TEST(ResultsFile, ReadsTheLineOfTheFormatsPage) {
    const auto results = results_of(
        R"({"timestamp_us": 33333, "part": {"state": "tracking", "rotation": [[1,0,0],[0,1,0],[0,0,1]],)"
        R"( "translation": [0, 0, 0.9], "at_rest": true, "fitness": 0.93}, "joints": {"head": [0.11, 0.2, 1.77]},)"
        R"( "pose_energy": 3.1, "pointing": {"arm": "right", "origin": [0,0,1.4], "direction": [0,1,0],)"
        R"( "hit_part": [0.30, 0.03, 0.12]}, "marks": [{"id": 7, "position_part": [0.30, 0.03, 0.12],)"
        R"( "zone": "upper left"}], "stage_ms": {"carve": 1.9, "total": 14.3}})");
    ASSERT_TRUE(results) << results.error().sentence;
    EXPECT_TRUE(results->warnings.empty());
    const ResultFrame& frame = results->frames.at(0);
    EXPECT_EQ(frame.part->state, PartState::tracking);
    EXPECT_EQ(frame.part->world_from_part->translation, Eigen::Vector3d(0, 0, 0.9));
    EXPECT_EQ(frame.pointing->arm, ArmSide::right);
    EXPECT_EQ(*frame.pointing->hit_part, Eigen::Vector3d(0.3, 0.03, 0.12));
    EXPECT_EQ(frame.marks.at(0).id, 7);
    EXPECT_EQ(frame.marks.at(0).zone, "upper left");
    EXPECT_EQ(frame.stage_ms.at("total"), 14.3);
}

TEST(ResultsFile, UnknownThingsAreNull) {
    const auto results = results_of(
        R"({"timestamp_us": 1, "part": {"state": "lost", "rotation": null, "translation": null}, "joints": null,)"
        R"( "pose_energy": null, "pointing": null, "marks": [], "stage_ms": {"total": 3}})");
    ASSERT_TRUE(results) << results.error().sentence;
    EXPECT_FALSE(results->frames[0].part->world_from_part);
    EXPECT_FALSE(results->frames[0].pointing);
}

struct BadResultLine {
    const char* line;
    const char* sentence;
};

class ResultsFileRefuses : public testing::TestWithParam<BadResultLine> {};

TEST_P(ResultsFileRefuses, WithOneSentence) {
    const auto results = results_of(
        std::string("{\"timestamp_us\": 1, \"marks\": [{\"id\": 1, \"position_part\": [0,0,0]}]}\n") +
        GetParam().line);
    ASSERT_FALSE(results);
    EXPECT_EQ(results.error().sentence, std::string("results.jsonl line 2: ") + GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Lines, ResultsFileRefuses,
    testing::Values(
        BadResultLine{"{\"timestamp_us\": 2", "not JSON"}, BadResultLine{"null", "expected a JSON object"},
        BadResultLine{"{\"marks\": []}", "timestamp_us is missing"},
        BadResultLine{"{\"timestamp_us\": 1}", "timestamp_us 1 does not rise"},
        BadResultLine{"{\"timestamp_us\": 2, \"part\": {}}", "part.state is missing"},
        BadResultLine{"{\"timestamp_us\": 2, \"part\": {\"state\": \"gone\"}}",
                      "part.state is \"gone\", expected absent, searching, ambiguous, tracking or lost"},
        BadResultLine{"{\"timestamp_us\": 2, \"part\": {\"state\": \"tracking\"}}",
                      "part.rotation is missing in state tracking"},
        BadResultLine{"{\"timestamp_us\": 2, \"part\": {\"state\": \"lost\", \"translation\": [1,2,3]}}",
                      "part.translation stands without state tracking"},
        BadResultLine{"{\"timestamp_us\": 2, \"part\": {\"state\": \"lost\", \"fitness\": true}}",
                      "part.fitness is true, expected a finite number"},
        BadResultLine{"{\"timestamp_us\": 2, \"pointing\": {\"arm\": \"up\"}}",
                      "pointing.arm is \"up\", expected \"left\" or \"right\""},
        BadResultLine{"{\"timestamp_us\": 2, \"marks\": {}}", "marks is {}, expected an array of objects"},
        BadResultLine{"{\"timestamp_us\": 2, \"marks\": [4]}", "marks is [4], expected an array of objects"},
        BadResultLine{"{\"timestamp_us\": 2, \"marks\": [{}]}", "a mark has no id"},
        BadResultLine{"{\"timestamp_us\": 2, \"marks\": [{\"id\": 3}]}", "mark 3 has no position_part"},
        BadResultLine{"{\"timestamp_us\": 2, \"marks\": [{\"id\": 1, \"position_part\": [0,0,0]}]}",
                      "mark 1 was there before"},
        BadResultLine{"{\"timestamp_us\": 2, \"stage_ms\": {\"total\": \"3\"}}",
                      "stage_ms.total is \"3\", expected a finite number"}));

}  // namespace
}  // namespace deixis
