// The results line: every key of formats.md, null for what is unknown, never a stale value.
#include "appliance/station/frame_result.h"

#include <gtest/gtest.h>

namespace deixis {
namespace {

TEST(FrameResult, UnknownThingsAreNull) {
    FrameResult result;
    result.timestamp_us = 33'333;
    const auto json = to_json(result);
    EXPECT_EQ(json["timestamp_us"], 33'333);
    EXPECT_EQ(json["part"]["state"], "absent");
    EXPECT_FALSE(json["part"].contains("rotation"));
    EXPECT_FALSE(json["part"].contains("translation"));
    EXPECT_TRUE(json["joints"].is_null());
    EXPECT_TRUE(json["pointing"].is_null());
    EXPECT_TRUE(json["marks"].is_array() && json["marks"].empty());
    EXPECT_EQ(json["stage_ms"]["total"], 0.0);
}

TEST(FrameResult, PoseStandsOnlyWithTracking) {
    FrameResult result;
    result.part.world_from_part.translation = {1, 2, 3};
    result.part.fitness = 0.9;
    for (const PartState state :
         {PartState::absent, PartState::searching, PartState::ambiguous, PartState::lost}) {
        result.part.state = state;
        const auto json = to_json(result);
        EXPECT_EQ(json["part"]["state"], name_of(state));
        EXPECT_FALSE(json["part"].contains("translation"));
        EXPECT_TRUE(json["part"]["fitness"].is_null());
    }
    result.part.state = PartState::tracking;
    const auto json = to_json(result);
    EXPECT_EQ(json["part"]["translation"], nlohmann::json({1.0, 2.0, 3.0}));
    EXPECT_EQ(json["part"]["rotation"][0], nlohmann::json({1.0, 0.0, 0.0}));
    EXPECT_EQ(json["part"]["fitness"], 0.9);
}

TEST(FrameResult, PointingAndMarks) {
    FrameResult result;
    result.pointing =
        PointingRay{ArmSide::left, {0, 0, 1.4}, {0, 1, 0}, PartSpot{{0.3, 0.03, 0.12}, {0, -1, 0}}};
    result.marks.push_back(
        {7, {1, {{0.30000049, 0.03, 0.12}, {0, -1, 0}}, ArmSide::left, 0.75, false}, "upper left"});
    const auto json = to_json(result);
    EXPECT_EQ(json["pointing"]["arm"], "left");
    EXPECT_EQ(json["pointing"]["hit_part"][0], 0.3);
    EXPECT_EQ(json["marks"][0]["id"], 7);
    EXPECT_EQ(json["marks"][0]["zone"], "upper left");
    EXPECT_EQ(json["marks"][0]["position_part"][0], 0.3) << "rounded to the micrometre";
    result.pointing->hit.reset();
    result.marks[0].zone.clear();
    EXPECT_TRUE(to_json(result)["pointing"]["hit_part"].is_null());
    EXPECT_TRUE(to_json(result)["marks"][0]["zone"].is_null());
}

TEST(FrameResult, SameResultSameBytesApartFromStageMs) {
    FrameResult a;
    a.part.state = PartState::tracking;
    a.part.world_from_part.translation = {-0.0, 0.1 + 0.2, 1e-12};
    FrameResult b = a;
    b.stage_ms.total = 17;
    auto first = to_json(a), second = to_json(b);
    EXPECT_NE(first.dump(), second.dump());
    first.erase("stage_ms");
    second.erase("stage_ms");
    EXPECT_EQ(first.dump(), second.dump());
    EXPECT_EQ(first["part"]["translation"].dump(), "[0.0,0.3,0.0]") << "no negative zero";
}

}  // namespace
}  // namespace deixis
