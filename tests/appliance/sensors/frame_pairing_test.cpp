// Pairing against the plain rule of the formats: for each frame the nearest of every other sensor within the
// window.
#include "appliance/sensors/frame_pairing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>

namespace deixis {
namespace {

constexpr int64_t window_us = 17'000;

DepthFrame frame_at(int64_t timestamp_us) {
    DepthFrame frame;
    frame.present = true;
    frame.timestamp_us = timestamp_us;
    frame.depth.resize(1, 1);
    frame.depth.millimetres[0] = static_cast<uint16_t>(timestamp_us % 60'000);
    return frame;
}

std::optional<int64_t> nearest_of(const std::vector<int64_t>& stamps, int64_t timestamp_us) {
    std::optional<int64_t> best;
    for (const int64_t s : stamps)
        if (std::abs(s - timestamp_us) <= window_us &&
            (!best || std::abs(s - timestamp_us) < std::abs(*best - timestamp_us)))
            best = s;
    return best;
}

/// Feeds frames as lock-step does: a partner stream only until it has passed the frame or has no more.
void expect_the_plain_rule(const std::vector<std::vector<int64_t>>& stamps) {
    FramePairing pairing(stamps.size(), window_us);
    std::vector<size_t> next(stamps.size(), 0);
    Frameset out;
    for (const int64_t t : stamps[0]) {
        DepthFrame frame = frame_at(t);
        pairing.put(0, frame);
        for (size_t s = 1; s < stamps.size(); ++s) {
            pairing.forget_before(s, t);
            while (!pairing.has_passed(s, t) && next[s] < stamps[s].size()) {
                DepthFrame other = frame_at(stamps[s][next[s]++]);
                pairing.put(s, other);
                pairing.forget_before(s, t);
                ASSERT_LE(pairing.waiting(s), 2U);
            }
        }
        pairing.take(0, out);
        ASSERT_EQ(out.timestamp_us, t);
        ASSERT_TRUE(out.frames[0].present);
        ASSERT_EQ(out.frames[0].timestamp_us, t);
        for (size_t s = 1; s < stamps.size(); ++s) {
            const auto expected = nearest_of(stamps[s], t);
            ASSERT_EQ(out.frames[s].present, expected.has_value()) << "frame at " << t << ", sensor " << s;
            if (!expected) continue;
            ASSERT_EQ(out.frames[s].timestamp_us, *expected) << "frame at " << t << ", sensor " << s;
            ASSERT_EQ(out.frames[s].depth.millimetres[0], *expected % 60'000);
        }
    }
    EXPECT_EQ(pairing.waiting(0), 0U);
}

TEST(FramePairing, FollowsThePlainRuleForRandomStreams) {
    std::mt19937 random(7);
    for (int round = 0; round < 300; ++round) {
        std::vector<std::vector<int64_t>> stamps(1 + random() % 4);
        for (auto& stream : stamps) {
            int64_t t = static_cast<int64_t>(random() % 200'000);
            const int64_t gap = 1 + static_cast<int64_t>(random() % 60'000);
            const size_t count = random() % 60;
            for (size_t i = 0; i < count; ++i) {
                stream.push_back(t);
                t += 1 + gap / 2 + static_cast<int64_t>(random()) % (gap + 1);
                if (random() % 10 == 0) t += 200'000;
            }
        }
        expect_the_plain_rule(stamps);
    }
}

TEST(FramePairing, TakesExactlyTheWindowAndNothingBeyond) {
    expect_the_plain_rule({{100'000, 200'000, 300'000}, {83'000, 182'999, 317'000}});
    FramePairing pairing(2, window_us);
    DepthFrame a = frame_at(100'000), b = frame_at(117'000);
    pairing.put(0, a);
    pairing.put(1, b);
    Frameset out;
    pairing.take(0, out);
    EXPECT_TRUE(out.frames[1].present);
    DepthFrame c = frame_at(200'000), d = frame_at(217'001);
    pairing.put(0, c);
    pairing.put(1, d);
    pairing.take(0, out);
    EXPECT_FALSE(out.frames[1].present);
    EXPECT_EQ(out.frames[1].timestamp_us, 217'001);  // goes along for who can use it
}

TEST(FramePairing, ALongGoneFrameDoesNotGoAlong) {
    FramePairing pairing(2, window_us);
    DepthFrame old = frame_at(100'000), late = frame_at(200'001);
    pairing.put(1, old);
    pairing.put(0, late);
    Frameset out;
    pairing.take(0, out);
    EXPECT_FALSE(out.frames[1].present);
    EXPECT_TRUE(out.frames[1].depth.millimetres.empty());
}

TEST(FramePairing, OfTwoEquallyNearTakesTheEarlier) {
    FramePairing pairing(2, window_us);
    for (const int64_t t : {90'000, 110'000}) {
        DepthFrame f = frame_at(t);
        pairing.put(1, f);
    }
    DepthFrame f = frame_at(100'000);
    pairing.put(0, f);
    Frameset out;
    pairing.take(0, out);
    EXPECT_EQ(out.frames[1].timestamp_us, 90'000);
}

TEST(FramePairing, AMomentThatIsNoFramesTakesTheNearestOfAll) {
    FramePairing pairing(2, window_us);
    for (const int64_t t : {90'000, 120'000, 150'000}) {
        DepthFrame f = frame_at(t), g = frame_at(t + 40'000);
        pairing.put(0, f);
        pairing.put(1, g);
    }
    Frameset out;
    pairing.take_at(104'000, out);
    EXPECT_EQ(out.timestamp_us, 104'000);
    EXPECT_EQ(out.frames[0].timestamp_us, 90'000);
    EXPECT_TRUE(out.frames[0].present);
    EXPECT_FALSE(out.frames[1].present);
    pairing.take_at(121'000, out);
    EXPECT_EQ(out.frames[0].timestamp_us, 120'000);
    EXPECT_EQ(out.frames[1].timestamp_us, 130'000);
    EXPECT_TRUE(out.frames[0].present && out.frames[1].present);
}

TEST(FramePairing, KnowsWhenWaitingBringsNothingNearer) {
    FramePairing pairing(2, window_us);
    EXPECT_TRUE(pairing.may_come_nearer(1, 100'000, 33'333));
    DepthFrame f = frame_at(90'000);
    pairing.put(1, f);
    EXPECT_FALSE(pairing.may_come_nearer(1, 90'000, 33'333));
    EXPECT_FALSE(pairing.may_come_nearer(1, 106'666, 33'333));
    EXPECT_TRUE(pairing.may_come_nearer(1, 106'667, 33'333));
    EXPECT_FALSE(pairing.may_come_nearer(1, 80'000, 33'333)) << "it has passed";
}

TEST(FramePairing, OneFrameMayServeTwoFramesets) {
    FramePairing pairing(2, window_us);
    DepthFrame slow = frame_at(100'000);
    pairing.put(1, slow);
    Frameset out;
    for (const int64_t t : {95'000, 105'000}) {
        DepthFrame f = frame_at(t);
        pairing.put(0, f);
        pairing.take(0, out);
        EXPECT_TRUE(out.frames[1].present);
        EXPECT_EQ(out.frames[1].timestamp_us, 100'000);
    }
}

TEST(FramePairing, AnotherSensorMayClock) {
    FramePairing pairing(2, window_us);
    DepthFrame f = frame_at(100'000);
    pairing.put(1, f);
    Frameset out;
    pairing.take(1, out);
    EXPECT_EQ(out.timestamp_us, 100'000);
    EXPECT_FALSE(out.frames[0].present);
    EXPECT_TRUE(out.frames[1].present);
}

}  // namespace
}  // namespace deixis
