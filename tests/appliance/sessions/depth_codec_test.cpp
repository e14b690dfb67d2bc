// The pixel codecs against a plain reference, at their limits, and on bytes that no encoder wrote.
#include "appliance/sessions/depth_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/appliance/sessions/plain_depth_codec.h"
#include "tests/appliance/sessions/sample_images.h"

namespace deixis {
namespace {

using testing::flat_image;
using testing::noise_image;
using testing::room_image;
using Pixels = std::vector<uint16_t>;
using Bytes = std::vector<uint8_t>;

Pixels decoded(OniCodec codec, const Bytes& coded, size_t count) {
    Pixels pixels(count);
    const auto fault = decode_depth(codec, coded, pixels);
    EXPECT_FALSE(fault) << fault->expected << " at " << fault->offset;
    return pixels;
}

/// Encodes like the reference, and back to the same pixels.
void expect_round_trip(const Pixels& pixels) {
    DepthEncoder encoder;
    Bytes coded;
    const auto table = testing::plain_encode_table(pixels);
    ASSERT_EQ(encoder.encode(OniCodec::table, pixels, coded), table.has_value());
    if (table) {
        ASSERT_EQ(coded, *table);
        ASSERT_EQ(decoded(OniCodec::table, coded, pixels.size()), pixels);
    }
    const auto differences = testing::plain_encode_differences(pixels);
    ASSERT_EQ(encoder.encode(OniCodec::differences, pixels, coded), differences.has_value());
    if (differences) {
        ASSERT_EQ(coded, *differences);
        ASSERT_EQ(decoded(OniCodec::differences, coded, pixels.size()), pixels);
    }
    ASSERT_TRUE(encoder.encode(OniCodec::none, pixels, coded));
    ASSERT_EQ(coded.size(), 2 * pixels.size());
    ASSERT_EQ(decoded(OniCodec::none, coded, pixels.size()), pixels);
}

TEST(DepthCodec, SceneImagesAreThePlainReferenceToTheByte) {
    for (uint32_t seed = 0; seed < 5; ++seed) expect_round_trip(room_image(160, 120, seed).millimetres);
    expect_round_trip(room_image(33, 17, 7).millimetres);
}

TEST(DepthCodec, NoiseOfEveryWidthIsThePlainReferenceToTheByte) {
    for (const int largest : {0, 1, 5, 6, 7, 12, 63, 64, 65, 200, 9999, 32767, 32768, 40000, 65535})
        for (uint32_t seed = 0; seed < 4; ++seed)
            expect_round_trip(noise_image(61, 7, seed, static_cast<uint16_t>(largest)).millimetres);
}

TEST(DepthCodec, EveryTailIsRight) {
    // Length and run before the end decide which of count and waiting nibble are left over.
    std::mt19937 random(3);
    for (size_t count = 1; count <= 70; ++count) {
        for (int trial = 0; trial < 10; ++trial) {
            Pixels pixels(count, 1000);
            for (size_t i = 0; i < count; ++i)
                if (random() % 9 == 0) pixels[i] = static_cast<uint16_t>(900 + random() % 200);
            expect_round_trip(pixels);
        }
    }
}

TEST(DepthCodec, EveryStepFromEveryLevelIsRight) {
    for (const int level : {0, 63, 64, 1000, 32767, 32768, 65471, 65535}) {
        for (int d = -70; d <= 70; ++d) {
            const int next = level - d;
            if (next < 0 || next > 65535) continue;
            expect_round_trip(
                {static_cast<uint16_t>(level), static_cast<uint16_t>(next), static_cast<uint16_t>(level)});
        }
    }
}

TEST(DepthCodec, LongRunsAndOnePixel) {
    expect_round_trip({65534});
    expect_round_trip({0, 0});
    expect_round_trip(flat_image(640, 480, 0).millimetres);
    expect_round_trip(flat_image(641, 3, 65534).millimetres);
}

TEST(DepthCodec, TableHoldsUpTo65535ValuesInOrder) {
    Pixels rising(65535);
    std::iota(rising.begin(), rising.end(), uint16_t{0});
    expect_round_trip(rising);
    rising.push_back(65535);
    DepthEncoder encoder;
    Bytes coded;
    EXPECT_FALSE(encoder.encode(OniCodec::table, rising, coded)) << "65536 values do not fit a 16 bit count";
    EXPECT_TRUE(encoder.encode(OniCodec::differences, rising, coded));
}

TEST(DepthCodec, OnlyJumpsToHighValuesHaveNoCode) {
    DepthEncoder encoder;
    Bytes coded;
    EXPECT_TRUE(encoder.encode(OniCodec::differences, Pixels{0, 32767, 0}, coded));
    EXPECT_FALSE(encoder.encode(OniCodec::differences, Pixels{0, 32768, 0}, coded));
    EXPECT_TRUE(encoder.encode(OniCodec::table, Pixels{0, 65534, 0, 65535}, coded)) << "indices are small";
    Pixels many(40000);
    std::iota(many.begin(), many.end(), uint16_t{0});
    many.push_back(5);
    many.push_back(39999);
    EXPECT_FALSE(encoder.encode(OniCodec::table, many, coded)) << "a jump to index 39999";
}

TEST(DepthCodec, EncodersKeepNothingBetweenFrames) {
    DepthEncoder used;
    Bytes first;
    Bytes again;
    ASSERT_TRUE(used.encode(OniCodec::table, noise_image(50, 50, 1, 9999).millimetres, first));
    for (uint32_t seed = 0; seed < 10; ++seed) {
        const Pixels pixels = noise_image(40, 30, seed, static_cast<uint16_t>(50 << seed)).millimetres;
        DepthEncoder fresh;
        ASSERT_EQ(used.encode(OniCodec::table, pixels, again), fresh.encode(OniCodec::table, pixels, first));
        ASSERT_EQ(again, first);
    }
}

TEST(DepthCodec, TheRecordersSwappedEndIsReadAsThePlayerReadsIt) {
    // 1 2 2 2: nibbles 5 | 6 6 -> the Recorder may write the lone nibble before the last count.
    EXPECT_EQ(decoded(OniCodec::differences, {1, 0, 0x5D, 0xE1}, 4), (Pixels{1, 2, 2, 2}));
}

struct BadCode {
    Bytes coded;
    size_t offset;
    const char* expected;
};

TEST(DepthCodec, RefusesWhatNoEncoderWrites) {
    const std::vector<BadCode> differences = {
        {{}, 0, "the first value, two bytes"},
        {{1}, 0, "the first value, two bytes"},
        {{1, 0}, 2, "as many pixels as the image has"},
        {{1, 0, 0x66, 0x66, 0x66}, 4, "no more pixels than the image has"},
        {{1, 0, 0xE0}, 2, "a run of at least one pair"},
        {{1, 0, 0xE3}, 2, "no more pixels than the image has"},
        {{1, 0, 0xD6}, 2, "a difference of at most 6 in the high nibble"},
        {{1, 0, 0x6E}, 2, "a difference of at most 6, 0xD or 0xF in the low nibble"},
        {{1, 0, 0x6F}, 3, "more coded bytes"},
        {{1, 0, 0xFF}, 3, "more coded bytes"},
        {{1, 0, 0xFF, 0x10}, 4, "more coded bytes"},
        {{1, 0, 0x6D, 0x66, 0x66}, 3, "the end after a lone nibble"},
        {{1, 0, 0x96}, 2, "a value inside the table (16zT) or below 65536 (16zP)"},
        {{1, 0, 0x69}, 2, "a value inside the table (16zT) or below 65536 (16zP)"},
        {{1, 0, 0xFF, 0xFF}, 3, "a value inside the table (16zT) or below 65536 (16zP)"},
        {{0xFF, 0xFF, 0x06}, 2, "a value inside the table (16zT) or below 65536 (16zP)"},
        {{1, 0, 0x66, 0x66, 0xFF, 0xC0}, 5, "no more pixels than the image has"},
    };
    for (const BadCode& bad : differences) {
        Pixels pixels(5);
        const auto fault = decode_depth(OniCodec::differences, bad.coded, pixels);
        ASSERT_TRUE(fault) << ::testing::PrintToString(bad.coded);
        EXPECT_STREQ(fault->expected, bad.expected) << ::testing::PrintToString(bad.coded);
        EXPECT_EQ(fault->offset, bad.offset) << ::testing::PrintToString(bad.coded);
    }
    const std::vector<BadCode> tables = {
        {{}, 0, "the table's size, two bytes"},
        {{0, 0}, 0, "a table of at least one value"},
        {{2, 0, 1, 0, 2}, 5, "the whole table"},
        {{0xFF, 0xFF, 1, 0}, 4, "the whole table"},
        {{2, 0, 1, 0, 1, 0, 0, 0, 0x66, 0x66}, 4, "an ascending table"},
        {{2, 0, 9, 0, 1, 0, 0, 0, 0x66, 0x66}, 4, "an ascending table"},
        {{1, 0, 9, 0}, 4, "the first value, two bytes"},
        {{1, 0, 9, 0, 1, 0}, 4, "a value inside the table (16zT) or below 65536 (16zP)"},
        {{1, 0, 9, 0, 0, 0, 0x56}, 6, "a value inside the table (16zT) or below 65536 (16zP)"},
    };
    for (const BadCode& bad : tables) {
        Pixels pixels(5);
        const auto fault = decode_depth(OniCodec::table, bad.coded, pixels);
        ASSERT_TRUE(fault) << ::testing::PrintToString(bad.coded);
        EXPECT_STREQ(fault->expected, bad.expected) << ::testing::PrintToString(bad.coded);
        EXPECT_EQ(fault->offset, bad.offset) << ::testing::PrintToString(bad.coded);
    }
    Pixels pixels(3);
    for (const size_t size : {0, 5, 7}) {
        const auto fault = decode_depth(OniCodec::none, Bytes(size), pixels);
        ASSERT_TRUE(fault);
        EXPECT_STREQ(fault->expected, "exactly two bytes a pixel");
    }
}

TEST(DepthCodec, RandomAndDamagedBytesNeverOverrun) {
    std::mt19937 random(11);
    DepthEncoder encoder;
    const Pixels image = room_image(40, 30, 1).millimetres;
    Bytes with_table;
    Bytes without;
    ASSERT_TRUE(encoder.encode(OniCodec::table, image, with_table));
    ASSERT_TRUE(encoder.encode(OniCodec::differences, image, without));
    Pixels pixels(image.size());
    int refused = 0;
    for (int trial = 0; trial < 10'000; ++trial) {
        const OniCodec codec = trial % 2 == 0 ? OniCodec::table : OniCodec::differences;
        Bytes bytes = trial % 2 == 0 ? with_table : without;
        if (trial % 3 == 0) bytes.resize(random() % (bytes.size() + 1));
        if (trial % 5 == 0)
            std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<uint8_t>(random()); });
        for (auto flips = random() % 4; flips > 0 && !bytes.empty(); --flips)
            bytes[random() % bytes.size()] ^= static_cast<uint8_t>(1U << random() % 8);
        // Exactly as long as it is, so that a sanitizer sees a read beyond it.
        const Bytes exact(bytes.begin(), bytes.end());
        const auto fault = decode_depth(codec, exact, pixels);
        if (fault) {
            ++refused;
            ASSERT_LE(fault->offset, exact.size());
        }
    }
    EXPECT_GT(refused, 5000);
}

}  // namespace
}  // namespace deixis
