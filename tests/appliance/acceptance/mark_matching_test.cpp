// Marks to gestures: every verdict, gestures without numbers, marks between gestures and in traps.
#include "appliance/acceptance/mark_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deixis {
namespace {

constexpr int64_t second = 1'000'000;

struct Gesture {
    std::optional<int64_t> hold;
    std::optional<bool> meant;
    int64_t first_us, last_us;
    std::optional<Eigen::Vector3d> spot;
};

Truth truth_with(const std::vector<Gesture>& gestures) {
    Truth truth;
    for (const Gesture& gesture : gestures) {
        for (int64_t t = gesture.first_us; t <= gesture.last_us; t += 33'333) {
            TruthFrame frame;
            frame.timestamp_us = t;
            frame.pointing = TruthPointing{gesture.hold, ArmSide::right, gesture.meant, false, gesture.spot};
            truth.frames.push_back(frame);
        }
    }
    return truth;
}

struct Made {
    int64_t time_us;
    Eigen::Vector3d position;
};

Results results_with(const std::vector<Made>& marks, ArmSide arm = ArmSide::right) {
    Results results;
    for (const Made& made : marks) {
        ResultFrame frame;
        frame.timestamp_us = made.time_us;
        frame.pointing = ResultPointing{arm, {}, {}, {}};
        frame.marks.push_back({int64_t(results.frames.size()) + 1, made.position, ""});
        results.frames.push_back(frame);
    }
    return results;
}

const Eigen::Vector3d left_spot(-0.5, 0, 0.2), right_spot(0.5, 0, 0.2);

TEST(MarkMatching, ExactlyOneNearMarkIsRight) {
    const Truth truth = truth_with({{1, true, 10 * second, 12 * second, left_spot}});
    const MarkMatch match =
        match_marks(truth, results_with({{11 * second, left_spot + Eigen::Vector3d(0.03, 0.04, 0)}}));
    ASSERT_EQ(match.holds.size(), 1U);
    EXPECT_EQ(match.holds[0].verdict, HoldVerdict::right);
    EXPECT_NEAR(*match.holds[0].distance_m, 0.05, 1e-12);
    EXPECT_EQ(match.holds[0].arm_right, true);
    EXPECT_EQ(match.marks[0].verdict, MarkVerdict::right);
    EXPECT_TRUE(match.all_right());
}

TEST(MarkMatching, ToleranceHoldsOnBothSidesOfItsEdge) {
    const Truth truth = truth_with({{1, true, 10 * second, 12 * second, Eigen::Vector3d(0, 0, 0)}});
    const MarkMatch inside = match_marks(truth, results_with({{11 * second, {0.0999, 0, 0}}}));
    const MarkMatch outside = match_marks(truth, results_with({{11 * second, {0.1001, 0, 0}}}));
    EXPECT_EQ(inside.holds[0].verdict, HoldVerdict::right);
    EXPECT_EQ(outside.holds[0].verdict, HoldVerdict::too_far);
    EXPECT_EQ(outside.marks[0].verdict, MarkVerdict::too_far);
    EXPECT_FALSE(outside.all_right());
    EXPECT_EQ(outside.false_marks(), 0U);
}

TEST(MarkMatching, NoMarkIsMissedAndTwoAreDoubled) {
    const Truth truth = truth_with(
        {{1, true, 10 * second, 12 * second, left_spot}, {2, true, 20 * second, 22 * second, right_spot}});
    const MarkMatch match =
        match_marks(truth, results_with({{21 * second, right_spot}, {22 * second, right_spot}}));
    EXPECT_EQ(match.holds[0].verdict, HoldVerdict::missed);
    EXPECT_EQ(match.holds[1].verdict, HoldVerdict::doubled);
    EXPECT_EQ(match.marks[0].verdict, MarkVerdict::right);
    EXPECT_EQ(match.marks[1].verdict, MarkVerdict::doubled);
    EXPECT_EQ(match.count(HoldVerdict::missed), 1U);
    EXPECT_EQ(match.count(HoldVerdict::doubled), 1U);
}

TEST(MarkMatching, AMarkMayComeShortlyAfterTheGestureButNotBeforeIt) {
    const Truth truth = truth_with({{1, true, 10 * second, 12 * second, left_spot}});
    EXPECT_TRUE(match_marks(truth, results_with({{13 * second, left_spot}})).all_right());
    const MarkMatch late = match_marks(truth, results_with({{14 * second, left_spot}}));
    EXPECT_EQ(late.holds[0].verdict, HoldVerdict::missed);
    EXPECT_EQ(late.false_marks(), 1U);
    EXPECT_EQ(match_marks(truth, results_with({{9 * second, left_spot}})).false_marks(), 1U);
}

TEST(MarkMatching, AMarkInATrapIsFalseEvenNearItsSpot) {
    const Truth truth = truth_with({{1, false, 10 * second, 12 * second, left_spot}});
    const MarkMatch match = match_marks(truth, results_with({{11 * second, left_spot}}));
    EXPECT_EQ(match.meant_holds(), 0U);
    EXPECT_EQ(match.false_marks(), 1U);
    EXPECT_FALSE(match.all_right());
}

TEST(MarkMatching, ATrapWithinTheGraceTimeTakesOnlyMarksThatAreNotTheGesturesOwn) {
    const Truth truth = truth_with({{1, true, 10 * second, 12 * second, left_spot},
                                    {2, false, 12 * second + 500'000, 13 * second, right_spot}});
    EXPECT_TRUE(match_marks(truth, results_with({{12 * second + 600'000, left_spot}})).all_right());
    const MarkMatch trapped =
        match_marks(truth, results_with({{11 * second, left_spot}, {12 * second + 600'000, right_spot}}));
    EXPECT_EQ(trapped.holds[0].verdict, HoldVerdict::right);
    EXPECT_EQ(trapped.false_marks(), 1U);
}

TEST(MarkMatching, BetweenTwoGesturesTheNearerSpotDecides) {
    const Truth truth = truth_with({{1, true, 10 * second, 12 * second, left_spot},
                                    {2, true, 12 * second + 400'000, 14 * second, right_spot}});
    const MarkMatch match =
        match_marks(truth, results_with({{12 * second + 500'000, left_spot}, {13 * second, right_spot}}));
    EXPECT_TRUE(match.all_right());
    EXPECT_EQ(match.marks[0].hold, 0U);
    EXPECT_EQ(match.marks[1].hold, 1U);
}

TEST(MarkMatching, WithoutASpotTimeAloneDecides) {
    const Truth truth = truth_with({{1, true, 10 * second, 12 * second, std::nullopt}});
    const MarkMatch match = match_marks(truth, results_with({{11 * second, {7, 7, 7}}}));
    EXPECT_TRUE(match.all_right());
    EXPECT_FALSE(match.holds[0].distance_m);
}

TEST(MarkMatching, GesturesWithoutNumbersAreToldApartByTimeAndSpot) {
    const Truth truth = truth_with({{7, true, second, 2 * second, left_spot},
                                    {std::nullopt, true, 4 * second, 5 * second, left_spot},
                                    {std::nullopt, true, 5 * second + 100'000, 6 * second, right_spot},
                                    {std::nullopt, true, 8 * second, 9 * second, right_spot}});
    const std::vector<TruthHold> holds = holds_of(truth);
    ASSERT_EQ(holds.size(), 4U);
    EXPECT_EQ(holds[0].hold, 7);
    EXPECT_EQ(holds[1].hold, 8);
    EXPECT_EQ(holds[3].hold, 10);
    EXPECT_EQ(holds[2].first_us, 5 * second + 100'000);
}

TEST(MarkMatching, AGestureIsMeantAsTheFirstLineThatSaysItElseMeant) {
    for (const std::optional<int64_t> number : {std::optional<int64_t>(3), std::optional<int64_t>()}) {
        const Truth truth =
            truth_with({{number, std::nullopt, 10 * second, 10 * second, left_spot},
                        {number, false, 10 * second + 100'000, 11 * second, std::nullopt},
                        {number, std::nullopt, 11 * second + 100'000, 12 * second, left_spot}});
        const std::vector<TruthHold> holds = holds_of(truth);
        ASSERT_EQ(holds.size(), 1U);
        EXPECT_FALSE(holds[0].meant);
        EXPECT_EQ(holds[0].target_part, left_spot);
    }
    EXPECT_TRUE(holds_of(truth_with({{1, std::nullopt, second, second, left_spot}}))[0].meant);
}

TEST(MarkMatching, TheOtherArmIsSaidButStaysRight) {
    const Truth truth = truth_with({{1, true, 10 * second, 12 * second, left_spot}});
    const MarkMatch match = match_marks(truth, results_with({{11 * second, left_spot}}, ArmSide::left));
    EXPECT_EQ(match.holds[0].arm_right, false);
    EXPECT_TRUE(match.all_right());
}

}  // namespace
}  // namespace deixis
