// truth.jsonl: what is read, what may be missing, and what is refused with which sentence.
#include "appliance/acceptance/truth_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace deixis {
namespace {

Result<Truth> truth_of(const std::string& text) {
    std::istringstream in(text);
    return read_truth(in, "truth.jsonl");
}

TEST(TruthFile, ReadsTheLineOfTheFormatsPage) {
    const auto truth = truth_of(
        R"({"timestamp_us": 33333, "joints": {"head": [0.1, 0.2, 1.78], "neck": [0.1, 0.2, 1.52]},)"
        R"( "part": {"rotation": [[1,0,0],[0,1,0],[0,0,1]], "translation": [0, 0, 0.9]},)"
        R"( "pointing": {"hold": 3, "arm": "right", "meant": true, "touch": false, "target_part": [0.31, 0.02, 0.12]}})");
    ASSERT_TRUE(truth) << truth.error().sentence;
    ASSERT_EQ(truth->frames.size(), 1U);
    const TruthFrame& frame = truth->frames[0];
    EXPECT_EQ(frame.timestamp_us, 33333);
    EXPECT_EQ(frame.joints.at("head"), Eigen::Vector3d(0.1, 0.2, 1.78));
    EXPECT_EQ(*frame.part_rotation, Eigen::Matrix3d::Identity());
    EXPECT_EQ(*frame.part_translation, Eigen::Vector3d(0, 0, 0.9));
    EXPECT_EQ(frame.pointing->hold, 3);
    EXPECT_EQ(frame.pointing->arm, ArmSide::right);
    EXPECT_EQ(frame.pointing->meant, true);
    EXPECT_EQ(frame.pointing->touch, false);
    EXPECT_EQ(*frame.pointing->target_part, Eigen::Vector3d(0.31, 0.02, 0.12));
    EXPECT_TRUE(truth->warnings.empty());
}

TEST(TruthFile, AnythingButTheStampMayBeMissingOrNull) {
    const auto truth = truth_of(
        "{\"timestamp_us\": 5}\n"
        "{\"timestamp_us\": 6, \"joints\": null, \"part\": null, \"pointing\": null}\n\n"
        "{\"timestamp_us\": 7, \"joints\": {\"head\": null}, \"part\": {\"rotation\": null, \"translation\": "
        "[1,2,3]}}\n"
        "{\"timestamp_us\": 8, \"pointing\": {}}\n"
        "{\"timestamp_us\": 9, \"pointing\": {\"hold\": null, \"arm\": null, \"meant\": null, "
        "\"target_part\": null}}\r\n");
    ASSERT_TRUE(truth) << truth.error().sentence;
    ASSERT_EQ(truth->frames.size(), 5U);
    EXPECT_FALSE(truth->frames[2].part_rotation);
    EXPECT_EQ(*truth->frames[2].part_translation, Eigen::Vector3d(1, 2, 3));
    EXPECT_FALSE(truth->frames[3].pointing->meant.has_value());
    EXPECT_FALSE(truth->frames[4].pointing->meant.has_value());
    EXPECT_FALSE(truth->frames[4].pointing->hold);
}

TEST(TruthFile, LinesOfSeveralSensorsComeOutByTime) {
    const auto truth = truth_of("{\"timestamp_us\": 30}\n{\"timestamp_us\": 10}\n{\"timestamp_us\": 20}\n");
    ASSERT_TRUE(truth);
    EXPECT_EQ(truth->frames[0].timestamp_us, 10);
    EXPECT_EQ(truth->frames[2].timestamp_us, 30);
}

TEST(TruthFile, AnUnknownKeyIsOneWarning) {
    const auto truth = truth_of("{\"timestamp_us\": 1, \"mood\": 3}\n{\"timestamp_us\": 2, \"mood\": 4}\n");
    ASSERT_TRUE(truth);
    EXPECT_THAT(truth->warnings, testing::ElementsAre("truth.jsonl line 1: unknown key mood"));
}

TEST(TruthFile, AnUnknownJointIsOneWarningAndTheOthersCount) {
    const auto truth = truth_of(
        "{\"timestamp_us\": 1, \"joints\": {\"left_hand\": [1,2,3], \"head\": [4,5,6]}}\n"
        "{\"timestamp_us\": 2, \"joints\": {\"left_hand\": \"?\", \"tail\": null}}\n");
    ASSERT_TRUE(truth) << truth.error().sentence;
    EXPECT_THAT(truth->warnings, testing::ElementsAre("truth.jsonl line 1: unknown key joints.left_hand",
                                                      "truth.jsonl line 2: unknown key joints.tail"));
    ASSERT_EQ(truth->frames[0].joints.size(), 1U);
    EXPECT_EQ(truth->frames[0].joints.at("head"), Eigen::Vector3d(4, 5, 6));
    EXPECT_TRUE(truth->frames[1].joints.empty());
}

TEST(TruthFile, ALineThatDoesNotSayWhetherAHoldIsMeantContradictsNone) {
    EXPECT_TRUE(
        truth_of("{\"timestamp_us\": 1, \"pointing\": {\"hold\": 2}}\n"
                 "{\"timestamp_us\": 2, \"pointing\": {\"hold\": 2, \"meant\": false}}\n"
                 "{\"timestamp_us\": 3, \"pointing\": {\"hold\": 2, \"meant\": null}}\n"));
    EXPECT_EQ(truth_of("{\"timestamp_us\": 1, \"pointing\": {\"hold\": 2}}\n"
                       "{\"timestamp_us\": 2, \"pointing\": {\"hold\": 2, \"meant\": false}}\n"
                       "{\"timestamp_us\": 3, \"pointing\": {\"hold\": 2, \"meant\": true}}\n")
                  .error()
                  .sentence,
              "truth.jsonl line 3: pointing.meant of hold 2 differs from an earlier line");
}

struct BadTruthLine {
    const char* line;
    const char* sentence;
};

class TruthFileRefuses : public testing::TestWithParam<BadTruthLine> {};

TEST_P(TruthFileRefuses, WithOneSentence) {
    const auto truth = truth_of(std::string("{\"timestamp_us\": 1}\n") + GetParam().line + "\n");
    ASSERT_FALSE(truth);
    EXPECT_EQ(truth.error().sentence, std::string("truth.jsonl line 2: ") + GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Lines, TruthFileRefuses,
    testing::Values(
        BadTruthLine{"{", "not JSON"}, BadTruthLine{"\xff\xfe", "not JSON"},
        BadTruthLine{"[1]", "expected a JSON object"}, BadTruthLine{"{}", "timestamp_us is missing"},
        BadTruthLine{"{\"timestamp_us\": null}", "timestamp_us is missing"},
        BadTruthLine{"{\"timestamp_us\": 1.5}", "timestamp_us is 1.5, expected a whole number of 64 bit"},
        BadTruthLine{"{\"timestamp_us\": 18446744073709551615}",
                     "timestamp_us is 18446744073709551615, expected a whole number of 64 bit"},
        BadTruthLine{"{\"timestamp_us\": \"1\"}", "timestamp_us is \"1\", expected a whole number of 64 bit"},
        BadTruthLine{"{\"timestamp_us\": 1, \"joints\": []}", "joints is [], expected an object"},
        BadTruthLine{"{\"timestamp_us\": 1, \"joints\": {\"head\": [1,2]}}",
                     "joints.head is [1,2], expected three finite numbers"},
        BadTruthLine{"{\"timestamp_us\": 1, \"part\": {\"translation\": [1,2,\"3\"]}}",
                     "part.translation is [1,2,\"3\"], expected three finite numbers"},
        BadTruthLine{"{\"timestamp_us\": 1, \"part\": {\"translation\": [1,2,1e999]}}", "not JSON"},
        BadTruthLine{"{\"timestamp_us\": 1, \"part\": {\"rotation\": [1,0,0]}}",
                     "part.rotation is [1,0,0], expected 3 rows of 3 finite numbers"},
        BadTruthLine{
            "{\"timestamp_us\": 1, \"part\": {\"rotation\": [[1,0,0],[0,1,0],[0,0,-1]]}}",
            "part.rotation is [[1,0,0],[0,1,0],[0,0,-1]], expected a rotation, orthonormal to 1e-4 and "
            "no reflection"},
        BadTruthLine{
            "{\"timestamp_us\": 1, \"part\": {\"rotation\": [[1,0,0],[0,1,0],[0,0.01,1]]}}",
            "part.rotation is [[1,0,0],[0,1,0],[0,0.01,1]], expected a rotation, orthonormal to 1e-4 and "
            "no reflection"},
        BadTruthLine{"{\"timestamp_us\": 1, \"pointing\": 3}", "pointing is 3, expected an object"},
        BadTruthLine{"{\"timestamp_us\": 1, \"pointing\": {\"hold\": 0}}",
                     "pointing.hold is 0, expected 1 or more"},
        BadTruthLine{"{\"timestamp_us\": 1, \"pointing\": {\"arm\": \"both\"}}",
                     "pointing.arm is \"both\", expected \"left\" or \"right\""},
        BadTruthLine{"{\"timestamp_us\": 1, \"pointing\": {\"meant\": 1}}",
                     "pointing.meant is 1, expected true or false"},
        BadTruthLine{"{\"timestamp_us\": 1, \"pointing\": {\"target_part\": {}}}",
                     "pointing.target_part is {}, expected three finite numbers"}));

TEST(TruthFile, RefusesAnEmptyFileAMissingOneAndAContradiction) {
    EXPECT_EQ(truth_of("").error().sentence, "truth.jsonl is empty: expected one JSON object a line");
    EXPECT_EQ(truth_of("\n \n").error().sentence, "truth.jsonl is empty: expected one JSON object a line");
    EXPECT_EQ(read_truth(std::filesystem::path("/no/such/file")).error().sentence,
              "/no/such/file cannot be read");
    EXPECT_EQ(truth_of("{\"timestamp_us\": 1, \"pointing\": {\"hold\": 2, \"meant\": true}}\n"
                       "{\"timestamp_us\": 2, \"pointing\": {\"hold\": 2, \"meant\": false}}\n")
                  .error()
                  .sentence,
              "truth.jsonl line 2: pointing.meant of hold 2 differs from an earlier line");
    EXPECT_EQ(
        truth_of("{\"timestamp_us\": 1, \"x\": \"" + std::string(1'000'000, 'a') + "\"}").error().sentence,
        "truth.jsonl line 1: longer than 1 MB");
}

TEST(TruthPartPose, IsInterpolatedBetweenNearLinesAndUnknownFarFromAny) {
    const auto truth = truth_of(
        "{\"timestamp_us\": 0, \"part\": {\"rotation\": [[1,0,0],[0,1,0],[0,0,1]], \"translation\": "
        "[0,0,0]}}\n"
        "{\"timestamp_us\": 10000, \"joints\": {}}\n"
        "{\"timestamp_us\": 40000, \"part\": {\"rotation\": [[0,-1,0],[1,0,0],[0,0,1]], \"translation\": "
        "[4,0,0]}}\n"
        "{\"timestamp_us\": 900000, \"part\": {\"translation\": [9,9,9]}}\n");
    ASSERT_TRUE(truth) << truth.error().sentence;
    const TruthPartPose between = part_pose_at(*truth, 10'000);
    EXPECT_LT((*between.translation - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
    const double angle = std::atan2((*between.rotation)(1, 0), (*between.rotation)(0, 0));
    EXPECT_NEAR(angle, 3.14159265358979 / 8, 1e-12);
    EXPECT_EQ(*part_pose_at(*truth, 40'000).translation, Eigen::Vector3d(4, 0, 0));
    EXPECT_EQ(*part_pose_at(*truth, 50'000).translation, Eigen::Vector3d(4, 0, 0));
    EXPECT_FALSE(part_pose_at(*truth, 500'000).translation);
    EXPECT_EQ(*part_pose_at(*truth, 900'000).translation, Eigen::Vector3d(9, 9, 9));
    EXPECT_FALSE(part_pose_at(*truth, 900'000).rotation);
    EXPECT_FALSE(part_pose_at(*truth, INT64_MAX).translation);
    EXPECT_FALSE(part_pose_at(*truth, INT64_MIN).translation);
}

}  // namespace
}  // namespace deixis
