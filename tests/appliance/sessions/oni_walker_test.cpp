// The walk before OpenNI2 opens a file: what is damaged, foreign or lying gets one sentence, and never a
// crash.
#include "appliance/sessions/oni_walker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <random>

#include "tests/appliance/sessions/oni_samples.h"

namespace deixis {
namespace {

using ::testing::HasSubstr;
using namespace testing;  // NOLINT: our own helpers

template <class T>
void put_at(std::string& bytes, size_t at, T value) {
    ASSERT_LE(at + sizeof value, bytes.size());
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// Offset of the `nth` record of `type`, found by stepping over the records.
size_t record_at(const std::string& bytes, uint32_t type, int nth = 0) {
    size_t at = 24;
    while (at + 28 <= bytes.size()) {
        uint32_t head[5];
        std::memcpy(head, bytes.data() + at, sizeof head);
        if (head[1] == type && nth-- == 0) return at;
        at += size_t{head[3]} + head[4];
    }
    ADD_FAILURE() << "no record of type " << type;
    return 0;
}

size_t property_at(const std::string& bytes, const std::string& name) {
    // The name with its NUL behind its length: no other place looks like it.
    std::string pattern(4, '\0');
    pattern[0] = static_cast<char>(name.size() + 1);
    const size_t found = bytes.find(pattern + name + '\0');
    EXPECT_NE(found, std::string::npos) << name;
    return found - 28;
}

std::string sentence_of(const std::string& bytes) {
    const auto walked = walk_oni(as_bytes(bytes), "bad.oni");
    return walked ? "passed" : walked.error().sentence;
}

constexpr uint32_t property_int = 0x03, removed = 0x07, begin = 0x08, ready = 0x09, data = 0x0A, end = 0x0B,
                   added = 0x0D, table = 0x0E;

struct BadRecording {
    const char* sentence;
    std::function<void(std::string&)> damage;
};

void cut_record(std::string& bytes, size_t at) {
    uint32_t head[5];
    std::memcpy(head, bytes.data() + at, sizeof head);
    bytes.erase(at, size_t{head[3]} + head[4]);
}

std::vector<BadRecording> bad_heads() {
    return {
        {"byte 0: expected the 24 bytes of an OpenNI2 recording's header", [](std::string& b) { b.clear(); }},
        {"byte 0: expected \"NI10\", the mark of an OpenNI2 recording", [](std::string& b) { b[0] = 'X'; }},
        {"byte 0: expected \"NI10\"", [](std::string& b) { b = std::string(4096, '\0'); }},
        {"byte 0: expected \"NI10\"",
         [](std::string& b) { b = "RIFF and so on, a film of something else entirely"; }},
        {"byte 6: expected format version 1.0.1.0", [](std::string& b) { b[6] = 2; }},
        {"byte 12: expected a largest timestamp below 2^62",
         [](std::string& b) { put_at(b, 12, ~uint64_t{1}); }},
        {"byte 12: expected a finished recording", [](std::string& b) { put_at(b, 12, ~uint64_t{0}); }},
        {"byte 20: expected 1 as the largest node id", [](std::string& b) { put_at(b, 20, 0x7FFFFFFFU); }},
        {"byte 24: expected a record (\"NIR\")", [](std::string& b) { b[24] = 'X'; }},
        {"byte 28: expected the node-added record (0x0D)", [](std::string& b) { put_at(b, 28, 0x0CU); }},
        {"byte 32: expected node id 1", [](std::string& b) { put_at(b, 32, 0xFFFFFFFFU); }},
        {"byte 36: expected a record of at least 28 bytes", [](std::string& b) { put_at(b, 36, 3U); }},
        {"byte 36: expected a record of at most 5760121 bytes",
         [](std::string& b) { put_at(b, 36, 0xFFFFFFFFU); }},
        {"byte 36: expected 74 bytes of node added", [](std::string& b) { put_at(b, 36, 75U); }},
        {"byte 40: expected no payload in node added", [](std::string& b) { put_at(b, 40, 4U); }},
        {"byte 44: expected an undo position before the record",
         [](std::string& b) { put_at(b, 44, uint64_t{24}); }},
        {"byte 52: expected the node's name", [](std::string& b) { b[57] = 'X'; }},
        {"byte 62: expected node type 2 (depth) or 5 (infrared)", [](std::string& b) { put_at(b, 62, 3U); }},
        {"byte 66: expected codec NONE, 16zP or 16zT", [](std::string& b) { put_at(b, 66, 0U); }},
        {"byte 66: expected codec NONE, 16zP or 16zT", [](std::string& b) { b.replace(66, 4, "JPEG"); }},
        {"expected frame 4 of 4", [](std::string& b) { put_at(b, 70, 4U); }},
        {"expected no frame after the 2 that node added counts", [](std::string& b) { put_at(b, 70, 2U); }},
        {"expected a finished recording", [](std::string& b) { put_at(b, 70, 0xFFFFFFFFU); }},
        {"expected no seek table in a recording of more than 288003",
         [](std::string& b) { put_at(b, 70, 288'004U); }},
        {"byte 74: expected a first timestamp not above the last",
         [](std::string& b) { put_at(b, 74, uint64_t{99999}); }},
        {"byte 82: expected a last timestamp not above the header's",
         [](std::string& b) { put_at(b, 82, uint64_t{99999}); }},
    };
}

std::vector<BadRecording> bad_properties() {
    return {
        {"expected a known property name",
         [](std::string& b) { b[property_at(b, "xnFOV") + 32] = static_cast<char>(0x80); }},
        {"expected a known property name", [](std::string& b) { b[property_at(b, "xnFOV") + 37] = 'x'; }},
        {"expected the length of a property name inside its record",
         [](std::string& b) { put_at(b, property_at(b, "xnFOV") + 28, 0xFFFFFFFFU); }},
        {"expected the length of a property name inside its record",
         [](std::string& b) { put_at(b, property_at(b, "xnFOV") + 28, 0U); }},
        {"expected the exact data size of property xnFOV",
         [](std::string& b) { put_at(b, property_at(b, "xnFOV") + 38, 0xFFFFFFFFU); }},
        {"expected the record type of property xnFOV",
         [](std::string& b) { put_at(b, property_at(b, "xnFOV") + 4, 3U); }},
        {"expected a property (0x03, 0x06) or state ready (0x09)",
         [](std::string& b) { put_at(b, property_at(b, "xnFOV") + 4, 5U); }},
        {"expected angles of 0 to 3.14 in property xnFOV",
         [](std::string& b) { put_at(b, property_at(b, "xnFOV") + 42, std::nan("")); }},
        {"expected property Mirror only once",
         [](std::string& b) {
             const size_t at = property_at(b, "Mirror");
             b.insert(at, b.substr(at, 28 + 4 + 7 + 4 + 8));
         }},
        {"expected property xnCropping before it",
         [](std::string& b) { cut_record(b, property_at(b, "xnCropping")); }},
        {"expected property xnMapOutputMode before it",
         [](std::string& b) { cut_record(b, property_at(b, "xnMapOutputMode")); }},
        {"expected property xnDeviceMaxDepth before it",
         [](std::string& b) { cut_record(b, property_at(b, "xnDeviceMaxDepth")); }},
        {"expected 1 to 65535 in property xnDeviceMaxDepth",
         [](std::string& b) {
             put_at(b, property_at(b, "xnDeviceMaxDepth") + 28 + 4 + 17 + 4, uint64_t{0});
         }},
        {"expected cropping off",
         [](std::string& b) { b[property_at(b, "xnCropping") + 28 + 4 + 11 + 4] = 1; }},
        {"expected an image of 1 to 2880000 pixels",
         [](std::string& b) { put_at(b, property_at(b, "xnMapOutputMode") + 28 + 4 + 16 + 4, 0xFFFFFFFFU); }},
        {"expected an image of 1 to 2880000 pixels",
         [](std::string& b) { put_at(b, property_at(b, "xnMapOutputMode") + 28 + 4 + 16 + 4, 0U); }},
        {"in property oniRequiredFrameSize",
         [](std::string& b) {
             put_at(b, property_at(b, "oniRequiredFrameSize") + 28 + 4 + 21 + 4, ~uint64_t{0});
         }},
        {"expected 100 in property oniPixelFormat",
         [](std::string& b) {
             put_at(b, property_at(b, "oniPixelFormat") + 28 + 4 + 15 + 4, uint64_t{101});
         }},
        {"expected as many modes as property xnSupportedMapOutputModesCount says",
         [](std::string& b) {
             put_at(b, property_at(b, "xnSupportedMapOutputModesCount") + 28 + 4 + 31 + 4, uint64_t{2});
         }},
        {"expected a property (0x03, 0x06) or state ready (0x09)",
         [](std::string& b) { cut_record(b, record_at(b, ready)); }},
        {"expected the data-begin record (0x08)", [](std::string& b) { cut_record(b, record_at(b, begin)); }},
        {"expected all ones in data begin", [](std::string& b) { b[record_at(b, begin) + 30] = 0; }},
        {"expected 28 bytes of state ready",
         [](std::string& b) { put_at(b, record_at(b, ready) + 12, 30U); }},
        {"expected no payload before the first frame",
         [](std::string& b) { put_at(b, record_at(b, property_int) + 16, 1U); }},
    };
}

std::vector<BadRecording> bad_frames() {
    return {
        {"expected frame id 2", [](std::string& b) { put_at(b, record_at(b, data, 1) + 36, 3U); }},
        {"expected frame id 1", [](std::string& b) { put_at(b, record_at(b, data) + 36, 0U); }},
        {"expected a timestamp not above the last one that the heads give",
         [](std::string& b) { put_at(b, record_at(b, data, 2) + 28, uint64_t{66'667}); }},
        {"expected a timestamp not before that of the frame before",
         [](std::string& b) { put_at(b, record_at(b, data) + 28, uint64_t{40'000}); }},
        {"expected a timestamp below 2^62",
         [](std::string& b) { put_at(b, record_at(b, data) + 28, ~uint64_t{0}); }},
        {"expected 40 bytes before a frame's pixels",
         [](std::string& b) {
             put_at(b, record_at(b, data) + 12, 41U);
             put_at(b, record_at(b, data) + 16, 0U);
         }},
        {"expected more of the recording",
         [](std::string& b) { put_at(b, record_at(b, data, 2) + 16, 5'000'000U); }},
        {"expected a record of at most 5760121 bytes",
         [](std::string& b) { put_at(b, record_at(b, data) + 16, 0xFFFFFFFFU); }},
        {"expected a table of at least one value in the pixels of frame 2",
         [](std::string& b) { put_at(b, record_at(b, data, 1) + 40, uint16_t{0}); }},
        {"expected the whole table in the pixels of frame 1",
         [](std::string& b) { put_at(b, record_at(b, data) + 40, uint16_t{0xFFFF}); }},
        {"expected frame 3 of 3", [](std::string& b) { cut_record(b, record_at(b, data, 2)); }},
        {"expected the seek table that node added places at byte",
         [](std::string& b) { cut_record(b, record_at(b, table)); }},
        {"expected no seek table here", [](std::string& b) { put_at(b, 90, uint64_t{1}); }},
        {"expected no seek table here", [](std::string& b) { put_at(b, 90, uint64_t{0}); }},
        {"expected 4 entries in the seek table",
         [](std::string& b) { put_at(b, record_at(b, table) + 16, 60U); }},
        {"expected stamp and place of frame 1 in the seek table",
         [](std::string& b) { put_at(b, record_at(b, table) + 28 + 20 + 12, uint64_t{1}); }},
        {"expected stamp and place of frame 0 in the seek table",
         [](std::string& b) { put_at(b, record_at(b, table) + 28, uint64_t{1}); }},
        {"expected configuration 0 in the seek table",
         [](std::string& b) { put_at(b, record_at(b, table) + 28 + 8, 1U); }},
        {"expected more of the recording (it ends within a record)",
         [](std::string& b) { b.resize(b.size() - 1); }},
        {"expected the end record (0x0B)", [](std::string& b) { b.resize(b.size() - 28); }},
        {"expected node id 0", [](std::string& b) { put_at(b, record_at(b, end) + 8, 1U); }},
        {"expected node removed, seek table and end after the frames",
         [](std::string& b) {
             const size_t at = record_at(b, removed);
             b.insert(at, b.substr(at, 28));
         }},
        {"expected nothing, or zeros, after the end record",
         [](std::string& b) { b += std::string(100, '\0') + "x"; }},
    };
}

TEST(OniWalker, RefusesEachDamageByByteAndExpectation) {
    const std::string good = small_recording(3);
    ASSERT_EQ(sentence_of(good), "passed");
    size_t tried = 0;
    for (const auto& group : {bad_heads(), bad_properties(), bad_frames()}) {
        for (const BadRecording& bad : group) {
            std::string bytes = good;
            bad.damage(bytes);
            const std::string sentence = sentence_of(bytes);
            EXPECT_THAT(sentence, HasSubstr("bad.oni: byte ")) << bad.sentence;
            EXPECT_THAT(sentence, HasSubstr(bad.sentence));
            EXPECT_EQ(sentence.find('\n'), std::string::npos);
            ++tried;
        }
    }
    EXPECT_GE(tried, 70U);
}

TEST(OniWalker, RefusesWhatIsNoFile) {
    const ScratchFolder scratch;
    EXPECT_THAT(walk_oni(scratch / "none.oni").error().sentence,
                HasSubstr("none.oni: cannot be opened: No such file"));
    EXPECT_THAT(walk_oni(scratch.path()).error().sentence, HasSubstr(": expected a regular file"));
    EXPECT_THAT(walk_oni("/dev/zero").error().sentence, HasSubstr("/dev/zero: expected a regular file"));
    EXPECT_THAT(read_oni_head(scratch / "none.oni").error().sentence, HasSubstr("cannot be opened"));
}

TEST(OniWalker, OptionalRecordsAndPropertiesMayBeMissing) {
    std::string bytes = small_recording(3);
    for (const char* name : {"oniRequiredFrameSize", "xnIsGenerating", "xnSupportedMapOutputModes",
                             "xnSupportedMapOutputModesCount", "xnSupportedPixelFormats", "xnPixelFormat",
                             "oniPixelFormat", "xnFOV", "Cropping", "Mirror", "xnMirror"})
        cut_record(bytes, property_at(bytes, name));
    cut_record(bytes, record_at(bytes, table));
    cut_record(bytes, record_at(bytes, removed));
    put_at(bytes, 90, uint64_t{0});
    const auto walked = walk_oni(as_bytes(bytes), "lean.oni");
    EXPECT_FALSE(walked) << "undo positions now lie behind their records";
    for (int i = 0; i < 3; ++i) put_at(bytes, record_at(bytes, data, i) + 20, uint64_t{0});
    EXPECT_EQ(sentence_of(bytes), "passed");
}

TEST(OniWalker, SkippedPixelsStillCheckEveryRecord) {
    std::string bytes = small_recording(3);
    put_at(bytes, record_at(bytes, data, 1) + 40, uint16_t{0});
    EXPECT_FALSE(walk_oni(as_bytes(bytes), "a.oni", OniPixels::decoded));
    EXPECT_TRUE(walk_oni(as_bytes(bytes), "a.oni", OniPixels::skipped));
    put_at(bytes, record_at(bytes, data, 1) + 36, 9U);
    EXPECT_FALSE(walk_oni(as_bytes(bytes), "a.oni", OniPixels::skipped));
}

TEST(OniWalker, ReadingStopsWhereTheCallerSays) {
    const std::string bytes = small_recording(5);
    int seen = 0;
    ASSERT_TRUE(read_oni(as_bytes(bytes), "a.oni", [&](int64_t frame, int64_t, const DepthImage&) {
        ++seen;
        return frame < 2;
    }));
    EXPECT_EQ(seen, 3);
}

TEST(OniWalker, RandomDamageIsRefusedOrHarmless) {
    const std::string good = small_recording(3);
    std::mt19937 random(5);
    int refused = 0;
    for (int trial = 0; trial < 10'000; ++trial) {
        std::string bytes = good;
        for (auto flips = 1 + random() % 3; flips > 0; --flips)
            bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
        if (trial % 7 == 0) put_at(bytes, random() % (bytes.size() - 8), ~uint64_t{0});
        if (trial % 11 == 0) bytes.erase(random() % bytes.size(), random() % 100);
        const std::string exact(bytes.begin(), bytes.end());
        const auto read = read_oni(as_bytes(exact), "flipped.oni",
                                   [](int64_t, int64_t, const DepthImage&) { return true; });
        if (read) continue;
        ++refused;
        ASSERT_THAT(read.error().sentence, HasSubstr("flipped.oni: byte "));
    }
    EXPECT_GT(refused, 5'000);
}

}  // namespace
}  // namespace deixis
