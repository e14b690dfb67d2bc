// The frame ring between a well-behaved child and the station: order, loss, concurrency, life of the name.
#include "appliance/sensors/frame_ring.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "appliance/sensors/host_clock.h"
#include "tests/appliance/sensors/ring_images.h"

namespace deixis {
namespace {

using test::numbered_image;
using Take = FrameRingReader::Take;

struct Ring {
    FrameRingReader reader;
    FrameRingWriter writer;
    RingGeometry geometry;

    void publish(uint32_t n) {
        const DepthImage image = numbered_image(geometry.width, geometry.height, n);
        writer.publish({int64_t{33'333} * n, host_now_us(), n}, image.millimetres);
    }
};

Ring make_ring(RingGeometry geometry) {
    auto reader = FrameRingReader::create(unique_ring_name(), geometry);
    EXPECT_TRUE(reader) << reader.error().sentence;
    auto writer = FrameRingWriter::attach(reader->name());
    EXPECT_TRUE(writer) << writer.error().sentence;
    return {std::move(*reader), std::move(*writer), geometry};
}

void expect_frame(Ring& ring, uint32_t n, int keep = 255) {
    DepthFrame frame;
    ASSERT_EQ(ring.reader.take(frame, keep), Take::frame) << ring.reader.refusal();
    EXPECT_TRUE(frame.present);
    EXPECT_EQ(frame.timestamp_us, int64_t{33'333} * n);
    EXPECT_EQ(ring.reader.frame_id(), n);
    EXPECT_EQ(frame.depth.millimetres,
              numbered_image(ring.geometry.width, ring.geometry.height, n).millimetres);
}

TEST(FrameRing, DeliversEveryFrameInOrderOverManyRounds) {
    Ring ring = make_ring({33, 17, 3, true});  // a size whose pixels do not fill whole words
    DepthFrame frame;
    EXPECT_EQ(ring.reader.take(frame, 1), Take::nothing);
    for (uint32_t n = 1; n <= 20; ++n) {
        ring.publish(n);
        expect_frame(ring, n);
    }
    EXPECT_EQ(ring.reader.take(frame, 1), Take::nothing);
    EXPECT_EQ(ring.reader.dropped(), 0U);
}

TEST(FrameRing, BlockingRingSaysWhenItIsFull) {
    Ring ring = make_ring({8, 8, 4, true});
    for (uint32_t n = 1; n <= 4; ++n) {
        EXPECT_FALSE(ring.writer.full());
        ring.publish(n);
    }
    EXPECT_TRUE(ring.writer.full());
    expect_frame(ring, 1);
    EXPECT_FALSE(ring.writer.full());
    ring.publish(5);
    EXPECT_TRUE(ring.writer.full());
    for (uint32_t n = 2; n <= 5; ++n) expect_frame(ring, n);
}

TEST(FrameRing, OverwritingRingKeepsTheNewestAndCountsTheRest) {
    Ring ring = make_ring({8, 8, 8, false});
    for (uint32_t n = 1; n <= 30; ++n) ring.publish(n);
    expect_frame(ring, 28, 3);
    EXPECT_EQ(ring.reader.dropped(), 27U);
    expect_frame(ring, 29, 3);
    expect_frame(ring, 30, 3);
    DepthFrame frame;
    EXPECT_EQ(ring.reader.take(frame, 3), Take::nothing);
    for (uint32_t n = 31; n <= 60; ++n) ring.publish(n);
    expect_frame(ring, 54, 255);  // all slots but the one that is next to be written
    EXPECT_EQ(ring.reader.dropped(), 27U + 23U);
}

TEST(FrameRing, NeverShowsATornFrameToAReaderThatIsOverrun) {
    Ring ring = make_ring({64, 48, 2, false});
    constexpr uint32_t frames = 3'000;
    std::thread child([&] {
        for (uint32_t n = 1; n <= frames; ++n) ring.publish(n);
        ring.writer.say(RingState::finished);
    });
    DepthFrame frame;
    uint64_t seen = 0, last = 0;
    while (last < frames) {
        const Take take = ring.reader.take(frame, 1);
        ASSERT_NE(take, Take::refused_ring) << ring.reader.refusal();
        ASSERT_NE(take, Take::refused_frame) << ring.reader.refusal();
        if (take == Take::nothing) continue;
        ASSERT_GT(ring.reader.frame_id(), last);
        last = ring.reader.frame_id();
        ASSERT_EQ(frame.depth.millimetres, numbered_image(64, 48, static_cast<uint32_t>(last)).millimetres);
        ++seen;
    }
    child.join();
    EXPECT_EQ(seen + ring.reader.dropped(), frames);
}

TEST(FrameRing, BlockingRingLosesNothingBetweenTwoThreads) {
    Ring ring = make_ring({64, 48, 3, true});
    constexpr uint32_t frames = 1'000;
    std::thread child([&] {
        for (uint32_t n = 1; n <= frames; ++n) {
            while (ring.writer.full()) std::this_thread::yield();
            ring.publish(n);
        }
    });
    DepthFrame frame;
    for (uint32_t n = 1; n <= frames;) {
        const Take take = ring.reader.take(frame, 1);
        if (take == Take::nothing) continue;
        ASSERT_EQ(take, Take::frame) << ring.reader.refusal();
        ASSERT_EQ(frame.depth.millimetres, numbered_image(64, 48, n++).millimetres);
    }
    child.join();
    EXPECT_EQ(ring.reader.dropped(), 0U);
}

TEST(FrameRing, ChildKilledInTheMiddleOfAWriteLeavesWholeFramesOnly) {
    for (int round = 0; round < 10; ++round) {
        auto reader = FrameRingReader::create(unique_ring_name(), {640, 480, 4, false});
        ASSERT_TRUE(reader) << reader.error().sentence;
        const pid_t child = fork();
        if (child == 0) {
            auto writer = FrameRingWriter::attach(reader->name());
            if (!writer) _exit(1);
            const DepthImage image = numbered_image(640, 480, 7);
            for (uint32_t n = 1;; ++n) writer->publish({n, host_now_us(), n}, image.millimetres);
        }
        const DepthImage expected = numbered_image(640, 480, 7);
        DepthFrame frame;
        const int64_t deadline = host_now_us() + 10'000'000;
        int frames = 0;
        const auto take_one = [&] {
            const Take take = reader->take(frame, 2);
            ASSERT_TRUE(take == Take::frame || take == Take::nothing) << reader->refusal();
            if (take == Take::frame) {
                ++frames;
                ASSERT_EQ(frame.depth.millimetres, expected.millimetres);
            }
        };
        while (frames < 3 + round && host_now_us() < deadline) take_one();
        kill(child, SIGKILL);
        waitpid(child, nullptr, 0);
        for (int i = 0; i < 8; ++i) take_one();
        ASSERT_GE(frames, 3);
        EXPECT_EQ(reader->take(frame, 2), Take::nothing);
    }
}

TEST(FrameRing, CarriesStateMessageAndHeartbeat) {
    Ring ring = make_ring({8, 8, 2, false});
    auto status = ring.reader.status();
    ASSERT_TRUE(status);
    EXPECT_EQ(status->state, RingState::starting);
    EXPECT_EQ(status->process_id, getpid());
    ring.writer.say(RingState::refused, "left.oni: byte 3: expected \"NI10\"");
    ring.writer.count_lost();
    status = ring.reader.status();
    ASSERT_TRUE(status);
    EXPECT_EQ(status->state, RingState::refused);
    EXPECT_EQ(status->message, "left.oni: byte 3: expected \"NI10\"");
    EXPECT_EQ(ring.reader.dropped(), 1U);
    const int64_t before = status->heartbeat_us;
    EXPECT_LE(before, host_now_us());
    ring.writer.beat();
    EXPECT_GE(ring.reader.status()->heartbeat_us, before);
    ring.writer.say(RingState::lost, std::string(2'000, 'x'));
    EXPECT_EQ(ring.reader.status()->message, std::string(255, 'x'));
    ring.writer.say(RingState::lost, "a\nb\tc");
    EXPECT_EQ(ring.reader.status()->message, "a?b?c");
    EXPECT_EQ(ring.writer.play_at_us(), 0);
    ring.reader.play_at(77);
    EXPECT_EQ(ring.writer.play_at_us(), 77);
}

bool name_exists(const std::string& name) {
    return std::filesystem::exists("/dev/shm/" + name);
}

TEST(FrameRing, NamesAreUniqueAndGoWithTheReader) {
    std::string name;
    {
        auto ring = FrameRingReader::create(unique_ring_name(), {8, 8, 2, true});
        ASSERT_TRUE(ring);
        name = ring->name();
        EXPECT_NE(name, unique_ring_name());
        EXPECT_TRUE(name_exists(name));
        const auto taken = FrameRingReader::create(name, {8, 8, 2, true});
        ASSERT_FALSE(taken);
        EXPECT_EQ(taken.error().sentence, "frame ring \"" + name + "\" cannot be made: File exists");
        EXPECT_TRUE(name_exists(name)) << "a refused second ring took the first one's name away";
    }
    EXPECT_FALSE(name_exists(name));
}

TEST(FrameRing, RemovesWhatKilledRunsLeftBehindAndNothingElse) {
    const pid_t child = fork();
    if (child == 0) {
        auto ring = FrameRingReader::create(unique_ring_name(), {8, 8, 2, true});
        kill(getpid(), SIGKILL);
    }
    waitpid(child, nullptr, 0);
    const std::string dead = "deixis-ring-" + std::to_string(child) + "-";
    const auto left_overs = [&] {
        int count = 0;
        for (const auto& entry : std::filesystem::directory_iterator("/dev/shm"))
            count += entry.path().filename().string().starts_with(dead) ? 1 : 0;
        return count;
    };
    ASSERT_EQ(left_overs(), 1);
    auto mine = FrameRingReader::create(unique_ring_name(), {8, 8, 2, true});
    ASSERT_TRUE(mine);
    // A living process of the same number that started at another time is not the one that made the ring.
    const std::string reused = "deixis-ring-" + std::to_string(getpid()) + "-1-1";
    std::ofstream("/dev/shm/" + reused) << "x";
    const std::string foreign = "deixis-test-" + std::to_string(getpid());
    std::ofstream("/dev/shm/" + foreign) << "x";
    EXPECT_GE(remove_left_over_rings(), 2);
    EXPECT_EQ(left_overs(), 0);
    EXPECT_TRUE(name_exists(mine->name()));
    EXPECT_FALSE(name_exists(reused));
    EXPECT_TRUE(name_exists(foreign));
    std::filesystem::remove("/dev/shm/" + foreign);
}

}  // namespace
}  // namespace deixis
