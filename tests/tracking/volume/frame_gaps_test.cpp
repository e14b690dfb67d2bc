// Which gaps of framesets are filled, and with what.
#include "tracking/volume/frame_gaps.h"

#include <gtest/gtest.h>

namespace deixis {
namespace {

DepthFrame frame_at(int64_t timestamp_us, bool present) {
    DepthFrame frame;
    frame.present = present;
    frame.timestamp_us = timestamp_us;
    frame.depth.resize(2, 1);
    frame.depth.millimetres = {1000, 2000};
    return frame;
}

TEST(FrameGaps, AFrameJustBeyondTheWindowStandsIn) {
    FrameGaps gaps({});
    for (const int64_t off : {-40'000, -17'001, 17'001, 40'000}) {
        const Frameset paired{500'000, {frame_at(500'000, true), frame_at(500'000 + off, false)}};
        const Frameset& filled = gaps.update(paired);
        EXPECT_EQ(filled.timestamp_us, 500'000);
        EXPECT_TRUE(filled.frames[0].present);
        EXPECT_TRUE(filled.frames[1].present) << off;
        EXPECT_EQ(filled.frames[1].timestamp_us, 500'000 + off);
        EXPECT_EQ(filled.frames[1].depth.at(1, 0), 2000);
        EXPECT_FALSE(paired.frames[1].present);
    }
}

TEST(FrameGaps, ASensorThatIsGoneStaysAbsent) {
    FrameGaps gaps({});
    Frameset paired{500'000, {frame_at(500'000, true), frame_at(459'999, false)}};
    EXPECT_FALSE(gaps.update(paired).frames[1].present);
    paired.frames[1] = DepthFrame{};
    EXPECT_FALSE(gaps.update(paired).frames[1].present);
    paired.frames[1] = frame_at(500'000, false);
    paired.frames[1].depth.millimetres.clear();
    EXPECT_FALSE(gaps.update(paired).frames[1].present);
}

TEST(FrameGaps, WholeFramesetsGoThroughUncopied) {
    FrameGaps gaps({});
    const Frameset paired{1, {frame_at(1, true), frame_at(2, true)}};
    EXPECT_EQ(&gaps.update(paired), &paired);
}

TEST(FrameGaps, NoReachMeansNoFilling) {
    FrameGaps gaps({.reach_ms = 0});
    const Frameset paired{500'000, {frame_at(500'000, true), frame_at(499'999, false)}};
    EXPECT_FALSE(gaps.update(paired).frames[1].present);
}

TEST(FrameGaps, ParamsNameWhatIsOutOfRange) {
    EXPECT_TRUE(FrameGaps::Params{}.validate().empty());
    EXPECT_EQ(FrameGaps::Params{.reach_ms = -1}.validate().size(), 1U);
    EXPECT_EQ(FrameGaps::Params{.reach_ms = 201}.validate().size(), 1U);
}

}  // namespace
}  // namespace deixis
