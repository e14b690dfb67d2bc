// A child that talks nonsense, and memory that is no ring: each is refused with its own sentence.
#include <gmock/gmock.h>

#include <algorithm>
#include <boost/interprocess/mapped_region.hpp>
#include <boost/interprocess/shared_memory_object.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "appliance/sensors/frame_ring.h"
#include "appliance/sensors/host_clock.h"
#include "tests/appliance/sensors/ring_images.h"

namespace deixis {
namespace {

namespace ipc = boost::interprocess;
using test::numbered_image;
using testing::HasSubstr;
using Take = FrameRingReader::Take;

/// A ring of 4 slots of 16x8 and the raw memory under it, as a child in a bad way has it.
struct RawRing {
    explicit RawRing(bool blocking = true)
        : reader(std::move(*FrameRingReader::create(unique_ring_name(), {16, 8, 4, blocking}))),
          writer(std::move(*FrameRingWriter::attach(reader.name()))) {
        const ipc::shared_memory_object memory(ipc::open_only, reader.name().c_str(), ipc::read_write);
        region = ipc::mapped_region(memory, ipc::read_write);
    }

    RingHeader& header() { return *static_cast<RingHeader*>(region.get_address()); }
    RingSlot& slot(uint32_t i) {
        auto* base = static_cast<std::byte*>(region.get_address());
        return *reinterpret_cast<RingSlot*>(base + sizeof(RingHeader) + i * ring_slot_bytes(16, 8));
    }
    uint16_t& pixel(uint32_t i, uint32_t p) { return reinterpret_cast<uint16_t*>(&slot(i) + 1)[p]; }
    void publish(uint64_t id, int64_t timestamp_us) {
        const DepthImage image = numbered_image(16, 8, static_cast<uint32_t>(id));
        writer.publish({timestamp_us, host_now_us(), id}, image.millimetres);
    }

    FrameRingReader reader;
    FrameRingWriter writer;
    ipc::mapped_region region;
};

struct Nonsense {
    const char* name;
    std::function<void(RawRing&)> act;  ///< after one good frame was taken and a second was published
    Take outcome;
    const char* sentence;
};

const std::vector<Nonsense>& nonsense() {
    static const std::vector<Nonsense> cases = {
        {"magic", [](RawRing& r) { r.header().magic = 42; }, Take::refused_ring,
         "does not begin with the ring's mark DEXRING1"},
        {"version", [](RawRing& r) { r.header().version = 9; }, Take::refused_ring,
         "has version 9, expected 1"},
        {"header size", [](RawRing& r) { r.header().header_bytes = 8; }, Take::refused_ring,
         "has a header of 8 bytes, expected"},
        {"no slots", [](RawRing& r) { r.header().slots = 0; }, Take::refused_ring,
         "has 0 slots, expected 2 to 256"},
        {"many slots", [](RawRing& r) { r.header().slots = 4'000'000'000U; }, Take::refused_ring,
         "has 4000000000 slots, expected 2 to 256"},
        {"no width", [](RawRing& r) { r.header().width = 0; }, Take::refused_ring,
         "has frames of 0x8, expected sides of 1 to 8192"},
        {"huge height", [](RawRing& r) { r.header().height = 100'000; }, Take::refused_ring,
         "has frames of 16x100000, expected sides of 1 to 8192"},
        {"mode", [](RawRing& r) { r.header().blocking = 7; }, Take::refused_ring,
         "has mode 7, expected 0 or 1"},
        {"mode changed", [](RawRing& r) { r.header().blocking = 0; }, Take::refused_ring,
         "changed its mode while in use"},
        {"slot size", [](RawRing& r) { r.header().slot_bytes = 1; }, Take::refused_ring,
         "has slots of 1 bytes, expected 320"},
        {"total size", [](RawRing& r) { r.header().total_bytes = 5; }, Take::refused_ring,
         "says it is 5 bytes long, expected"},
        {"consistent but other geometry",
         [](RawRing& r) {
             r.header().slots = 2;
             r.header().total_bytes = ring_total_bytes(2, 16, 8);
         },
         Take::refused_ring, "bytes long, expected"},
        {"another run", [](RawRing& r) { ++r.header().run; }, Take::refused_ring,
         "carries the number of another run"},
        {"taken", [](RawRing& r) { r.header().taken = 3; }, Take::refused_ring,
         "changed the count of frames taken, which is not the child's"},
        {"published backwards", [](RawRing& r) { r.header().published = 0; }, Take::refused_ring,
         "counts backwards: 0 frames after 1"},
        {"published beyond the ring", [](RawRing& r) { r.header().published = 99; }, Take::refused_ring,
         "holds 98 unread frames in 4 slots"},
        {"sequence of an older frame", [](RawRing& r) { r.slot(1).sequence = 0; }, Take::refused_ring,
         "has slot 1 at sequence 0, expected 4"},
        {"sequence odd", [](RawRing& r) { r.slot(1).sequence = 3; }, Take::refused_ring,
         "has slot 1 at sequence 3, expected 4"},
        {"sequence from the future", [](RawRing& r) { r.slot(1).sequence = 1'000; }, Take::refused_ring,
         "has slot 1 at sequence 1000, expected 4"},
        {"width of the frame", [](RawRing& r) { r.slot(1).width = 320; }, Take::refused_frame,
         "frame 2 of ring"},
        {"height of the frame", [](RawRing& r) { r.slot(1).height = 9; }, Take::refused_frame,
         "is 16x9, expected 16x8"},
        {"bytes of the frame", [](RawRing& r) { r.slot(1).pixel_bytes = 1'000'000; }, Take::refused_frame,
         "has 1000000 bytes of pixels, expected 256"},
        {"id repeated", [](RawRing& r) { r.slot(1).frame_id = 1; }, Take::refused_frame,
         "has id 1 after 1, expected ids to rise"},
        {"id left out", [](RawRing& r) { r.slot(1).frame_id = 5; }, Take::refused_frame,
         "has id 5 after 1: frames are missing"},
        {"negative stamp", [](RawRing& r) { r.slot(1).timestamp_us = -3; }, Take::refused_frame,
         "has the stamp -3 us, expected none below 0"},
        {"time backwards", [](RawRing& r) { r.slot(1).timestamp_us = 999; }, Take::refused_frame,
         "has the stamp 999 us after 1000 us: time runs backwards"},
        {"arrival to come", [](RawRing& r) { r.slot(1).host_us = INT64_MAX; }, Take::refused_frame,
         "arrived at 9223372036854775807 us of the host's clock, which is not now"},
        {"arrival before time", [](RawRing& r) { r.slot(1).host_us = -1; }, Take::refused_frame,
         "arrived at -1 us of the host's clock, which is not now"},
        {"checksum", [](RawRing& r) { ++r.slot(1).checksum; }, Take::refused_frame,
         "does not match its checksum"},
        {"pixel", [](RawRing& r) { r.pixel(1, 77) ^= 1; }, Take::refused_frame,
         "does not match its checksum"},
        {"last pixel", [](RawRing& r) { r.pixel(1, 127) ^= 0x8000; }, Take::refused_frame,
         "does not match its checksum"},
        {"65535",
         [](RawRing& r) {
             DepthImage image = numbered_image(16, 8, 3);
             image.millimetres[100] = 65535;
             DepthFrame second;
             ASSERT_EQ(r.reader.take(second, 3), Take::frame);
             r.writer.publish({3'000, host_now_us(), 3}, image.millimetres);
         },
         Take::refused_frame, "holds the value 65535, which is not a depth"},
    };
    return cases;
}

TEST(FrameRingNonsense, IsNamed) {
    for (const Nonsense& c : nonsense()) {
        SCOPED_TRACE(c.name);
        RawRing ring;
        ring.publish(1, 1'000);
        DepthFrame frame;
        ASSERT_EQ(ring.reader.take(frame, 3), Take::frame);
        ring.publish(2, 2'000);
        c.act(ring);
        EXPECT_EQ(ring.reader.take(frame, 3), c.outcome);
        EXPECT_THAT(ring.reader.refusal(), HasSubstr(c.sentence));
        EXPECT_THAT(ring.reader.refusal(), HasSubstr(ring.reader.name()));
        if (c.outcome == Take::refused_ring) {
            EXPECT_EQ(ring.reader.take(frame, 3), Take::refused_ring) << "a ring caught once is read again";
        } else {
            EXPECT_FALSE(frame.present);
        }
    }
}

TEST(FrameRingNonsense, GoodFramesGoOnAfterARefusedOne) {
    RawRing ring(false);
    DepthFrame frame;
    ring.publish(1, 1'000);
    ring.pixel(0, 5) ^= 4;
    EXPECT_EQ(ring.reader.take(frame, 3), Take::refused_frame);
    ring.publish(2, 2'000);
    EXPECT_EQ(ring.reader.take(frame, 3), Take::frame);
    EXPECT_EQ(frame.timestamp_us, 2'000);
}

TEST(FrameRingNonsense, ImpossibleCountOfAnOverwritingRing) {
    RawRing ring(false);
    ring.publish(1, 1'000);
    ring.header().published = uint64_t{1} << 60;
    DepthFrame frame;
    EXPECT_EQ(ring.reader.take(frame, 3), Take::refused_ring);
    EXPECT_THAT(ring.reader.refusal(), HasSubstr("at sequence 0, expected"));
}

struct BadStatus {
    const char* name;
    std::function<void(RingHeader&)> act;
    const char* sentence;
};

TEST(FrameRingNonsense, OfTheStatusIsNamed) {
    const BadStatus cases[] = {
        {"state 0", [](RingHeader& h) { h.state = 0; }, "is in state 0, which does not exist"},
        {"state 77", [](RingHeader& h) { h.state = 77; }, "is in state 77, which does not exist"},
        {"heartbeat to come", [](RingHeader& h) { h.heartbeat_us = INT64_MAX; }, "which is still to come"},
        {"heartbeat before time", [](RingHeader& h) { h.heartbeat_us = -5; }, "has a heartbeat at -5 us"},
        {"endless message",
         [](RingHeader& h) {
             for (auto& c : h.message) c = 'a';
         },
         "has a message without an end"},
        {"lost backwards", [](RingHeader& h) { h.lost_by_child = 1; },
         "counts lost frames backwards: 1 after 2"},
        {"magic", [](RingHeader& h) { h.magic = 0; }, "does not begin with the ring's mark"},
    };
    for (const BadStatus& c : cases) {
        SCOPED_TRACE(c.name);
        RawRing ring;
        ring.writer.count_lost();
        ring.writer.count_lost();
        ASSERT_TRUE(ring.reader.status());
        c.act(ring.header());
        const auto status = ring.reader.status();
        ASSERT_FALSE(status);
        EXPECT_THAT(status.error().sentence, HasSubstr(c.sentence));
        EXPECT_FALSE(ring.reader.status()) << "a ring caught once is believed again";
    }
}

/// A file in shared memory that goes with the test.
struct RawMemory {
    explicit RawMemory(const std::string& bytes) : name("deixis-test-" + unique_ring_name()) {
        std::ofstream("/dev/shm/" + name, std::ios::binary) << bytes;
    }
    ~RawMemory() { std::filesystem::remove("/dev/shm/" + name); }
    std::string name;
};

TEST(FrameRingNonsense, MemoryThatIsNoRingIsNotAttachedTo) {
    const auto refusal_of = [](const std::string& name) {
        const auto writer = FrameRingWriter::attach(name);
        return writer ? std::string("attached") : writer.error().sentence;
    };
    EXPECT_EQ(refusal_of(""), "frame ring \"\" is not a ring's name");
    EXPECT_EQ(refusal_of("../etc/passwd"), "frame ring \"../etc/passwd\" is not a ring's name");
    EXPECT_EQ(refusal_of(std::string(300, 'a')),
              "frame ring \"" + std::string(300, 'a') + "\" is not a ring's name");
    EXPECT_EQ(refusal_of("deixis-test-none"),
              "frame ring \"deixis-test-none\" cannot be opened: No such file or directory");
    const RawMemory empty(""), brief("DEXRING1"), zeros(std::string(100'000, '\0')),
        letters(std::string(4096, 'q'));
    EXPECT_THAT(refusal_of(empty.name), HasSubstr("is 0 bytes long, expected at least"));
    EXPECT_THAT(refusal_of(brief.name), HasSubstr("is 8 bytes long, expected at least"));
    EXPECT_THAT(refusal_of(zeros.name), HasSubstr("does not begin with the ring's mark DEXRING1"));
    EXPECT_THAT(refusal_of(letters.name), HasSubstr("does not begin with the ring's mark DEXRING1"));
    const RawRing ring;
    std::filesystem::resize_file("/dev/shm/" + ring.reader.name(), sizeof(RingHeader) + 64);
    EXPECT_THAT(refusal_of(ring.reader.name()), HasSubstr("is 512 bytes long, expected 1728"));
}

TEST(FrameRingNonsense, RandomDamageIsSurvived) {
    std::mt19937 random(11);
    int refused = 0;
    for (int round = 0; round < 4'000; ++round) {
        RawRing ring(round % 2 == 0);
        DepthFrame frame;
        for (uint64_t id = 1; id <= 6; ++id) {
            ring.publish(id, static_cast<int64_t>(id) * 1'000);
            auto* bytes = static_cast<unsigned char*>(ring.region.get_address());
            for (auto k = random() % 3; k > 0; --k) {
                const size_t at = random() % ring.region.get_size();
                bytes[at] = random() % 3 == 0 ? 0xFF : static_cast<unsigned char>(random());
            }
            const Take take = ring.reader.take(frame, 3);
            const auto status = ring.reader.status();
            if (take == Take::frame) {
                ASSERT_EQ(frame.depth.millimetres.size(), 16U * 8U);
                ASSERT_EQ(std::count(frame.depth.millimetres.begin(), frame.depth.millimetres.end(), 65535),
                          0);
            } else if (take != Take::nothing) {
                ASSERT_FALSE(ring.reader.refusal().empty());
                ++refused;
            }
            ASSERT_TRUE(status || !status.error().sentence.empty());
        }
    }
    EXPECT_GT(refused, 1'000);
}

TEST(FrameRingNonsense, ImpossibleGeometryIsNotMade) {
    const auto refusal_of = [](RingGeometry geometry) {
        const auto ring = FrameRingReader::create("deixis-test-geometry", geometry);
        return ring ? std::string("made") : ring.error().sentence;
    };
    EXPECT_THAT(refusal_of({0, 480, 8, true}),
                HasSubstr("cannot hold frames of 0x480, expected sides of 1 to 8192"));
    EXPECT_THAT(refusal_of({640, 8193, 8, true}), HasSubstr("cannot hold frames of 640x8193"));
    EXPECT_THAT(refusal_of({640, -1, 8, true}), HasSubstr("cannot hold frames of 640x-1"));
    EXPECT_THAT(refusal_of({640, 480, 1, true}), HasSubstr("cannot have 1 slots, expected 2 to 256"));
    EXPECT_THAT(refusal_of({640, 480, 257, true}), HasSubstr("cannot have 257 slots, expected 2 to 256"));
    EXPECT_FALSE(std::filesystem::exists("/dev/shm/deixis-test-geometry"));
}

}  // namespace
}  // namespace deixis
