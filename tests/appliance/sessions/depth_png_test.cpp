// Image files: round trips, and what is damaged, foreign or too large.
#include "appliance/sessions/depth_png.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <random>

#include "tests/appliance/sessions/oni_samples.h"

namespace deixis {
namespace {

using ::testing::HasSubstr;
using namespace testing;  // NOLINT: our own helpers

TEST(DepthPng, ReadsBackBitForBit) {
    const ScratchFolder scratch;
    for (const auto& [width, height] : {std::pair{1, 1}, {33, 17}, {640, 480}}) {
        const DepthImage image = noise_image(width, height, 3, 65534);
        ASSERT_TRUE(write_depth_png(image, scratch / "a.png"));
        const auto read = read_depth_png(scratch / "a.png", {width, height});
        ASSERT_TRUE(read) << read.error().sentence;
        EXPECT_EQ(read->millimetres, image.millimetres);
        EXPECT_EQ(read_infrared_png(scratch / "a.png", {width, height})->millimetres, image.millimetres);
    }
}

TEST(DepthPng, VideoReadsBackBitForBit) {
    const ScratchFolder scratch;
    std::mt19937 random(1);
    for (const int channels : {1, 3}) {
        VideoImage image{31, 9, channels, {}};
        for (int i = 0; i < 31 * 9 * channels; ++i)
            image.bytes.push_back(static_cast<uint8_t>(channels == 3 ? random() : random() % 2 * 255));
        ASSERT_TRUE(write_video_png(image, scratch / "v.png"));
        const auto read = read_video_png(scratch / "v.png", {31, 9});
        ASSERT_TRUE(read) << read.error().sentence;
        EXPECT_EQ(read->channels, channels);
        EXPECT_EQ(read->bytes, image.bytes);
    }
}

TEST(DepthPng, RedIsTheFirstOfTheThreeBytes) {
    const ScratchFolder scratch;
    ASSERT_TRUE(write_video_png({1, 1, 3, {255, 10, 0}}, scratch / "red.png"));
    // Uncompressed or not, the one pixel of a PNG stands in R, G, B order; another reader would see 255, 10,
    // 0 too.
    EXPECT_EQ(read_video_png(scratch / "red.png", {1, 1})->bytes, (std::vector<uint8_t>{255, 10, 0}));
}

TEST(DepthPng, AGreyVideoIsASilhouette) {
    const ScratchFolder scratch;
    std::vector<uint8_t> bytes(31 * 9, 255);
    bytes[40] = 0;
    ASSERT_TRUE(write_video_png({31, 9, 1, bytes}, scratch / "v.png"));
    EXPECT_EQ(read_video_png(scratch / "v.png", {31, 9})->bytes, bytes);
    for (const uint8_t wrong : std::vector<uint8_t>{1, 128, 254}) {
        bytes[40] = wrong;
        ASSERT_TRUE(write_video_png({31, 9, 1, bytes}, scratch / "v.png"));
        const auto read = read_video_png(scratch / "v.png", {31, 9});
        ASSERT_FALSE(read);
        EXPECT_EQ(read.error().sentence, (scratch / "v.png").string() +
                                             ": pixel (9, 1): expected 0 or 255 of a silhouette, found " +
                                             std::to_string(wrong));
    }
}

/// With the chunk behind the head, where tRNS belongs.
std::string with_chunk(std::string png, const std::string& chunk) {
    return png.insert(33, chunk);
}

TEST(DepthPng, ATransparentColourLeavesTheValuesAsTheyStand) {
    const ScratchFolder scratch;
    const std::string colour_9_9_9("\0\0\0\6tRNS\0\x09\0\x09\0\x09\x15\xbb\xe6\xcb", 18);
    const std::string grey_0("\0\0\0\2tRNS\0\0\x76\x93\xcd\x38", 14);
    const VideoImage rgb{2, 1, 3, {9, 9, 9, 255, 10, 0}};
    ASSERT_TRUE(write_video_png(rgb, scratch / "rgb.png"));
    const auto film =
        decode_video_png(as_bytes(with_chunk(bytes_of(scratch / "rgb.png"), colour_9_9_9)), "a.png", {2, 1});
    ASSERT_TRUE(film) << film.error().sentence;
    EXPECT_EQ(film->channels, 3);
    EXPECT_EQ(film->bytes, rgb.bytes);
    ASSERT_TRUE(write_video_png({2, 1, 1, {0, 255}}, scratch / "grey.png"));
    const std::string silhouette = with_chunk(bytes_of(scratch / "grey.png"), grey_0);
    EXPECT_EQ(decode_video_png(as_bytes(silhouette), "a.png", {2, 1})->bytes, (std::vector<uint8_t>{0, 255}));
    EXPECT_EQ(decode_infrared_png(as_bytes(silhouette), "a.png", {2, 1})->millimetres,
              (std::vector<uint16_t>{0, 255}));
    const DepthImage depth = room_image(20, 10, 1);
    ASSERT_TRUE(write_depth_png(depth, scratch / "depth.png"));
    EXPECT_EQ(
        decode_depth_png(as_bytes(with_chunk(bytes_of(scratch / "depth.png"), grey_0)), "a.png", {20, 10})
            ->millimetres,
        depth.millimetres);
}

TEST(DepthPng, EightBitInfraredKeepsItsValues) {
    const ScratchFolder scratch;
    ASSERT_TRUE(write_video_png({3, 1, 1, {0, 128, 255}}, scratch / "ir.png"));
    EXPECT_EQ(read_infrared_png(scratch / "ir.png", {3, 1})->millimetres,
              (std::vector<uint16_t>{0, 128, 255}));
}

TEST(DepthPng, RefusesEachWrongFileInOneSentence) {
    const ScratchFolder scratch;
    DepthImage image = noise_image(20, 10, 1, 5000);
    ASSERT_TRUE(write_depth_png(image, scratch / "good.png"));
    image.millimetres[45] = 65535;
    ASSERT_TRUE(write_depth_png(image, scratch / "full.png"));
    ASSERT_TRUE(write_video_png({20, 10, 1, std::vector<uint8_t>(200)}, scratch / "grey8.png"));
    ASSERT_TRUE(write_video_png({20, 10, 3, std::vector<uint8_t>(600)}, scratch / "rgb.png"));
    const std::string good = bytes_of(scratch / "good.png");
    std::string huge = good;
    huge.replace(16, 8, std::string("\x7F\xFF\xFF\xFF\x7F\xFF\xFF\xFF", 8));
    std::string claims = good;
    claims[19] = 21;
    std::string flipped = good;
    flipped[60] = static_cast<char>(~flipped[60]);
    std::string palette = good;
    palette[25] = 3;
    const auto depth = [](const std::string& bytes) {
        const auto read = decode_depth_png(as_bytes(bytes), "a.png", {20, 10});
        return read ? "accepted" : read.error().sentence;
    };
    EXPECT_EQ(depth(good), "accepted");
    EXPECT_EQ(depth(""), "a.png: byte 0: expected a PNG file");
    EXPECT_EQ(depth("\x89PNG"), "a.png: byte 0: expected a PNG file");
    EXPECT_EQ(depth(std::string(5000, 'x')), "a.png: byte 0: expected a PNG file");
    EXPECT_EQ(depth(huge), "a.png: expected 20 x 10 pixels, found 2147483647 x 2147483647");
    EXPECT_EQ(depth(claims), "a.png: expected 20 x 10 pixels, found 21 x 10");
    EXPECT_EQ(depth(flipped), "a.png: expected a whole, undamaged PNG file");
    EXPECT_EQ(depth(palette), "a.png: expected 16 bit grey, found 16 bit of PNG colour type 3");
    EXPECT_EQ(depth(good.substr(0, good.size() / 2)), "a.png: expected a whole, undamaged PNG file");
    EXPECT_EQ(depth(bytes_of(scratch / "grey8.png")), "a.png: expected 16 bit grey, found 8 bit grey");
    EXPECT_EQ(depth(bytes_of(scratch / "rgb.png")), "a.png: expected 16 bit grey, found 8 bit RGB");
    EXPECT_EQ(depth(bytes_of(scratch / "full.png")),
              "a.png: pixel (5, 2): expected 0 to 65534 mm, found 65535");
    EXPECT_EQ(decode_video_png(as_bytes(good), "a.png", {20, 10}).error().sentence,
              "a.png: expected 8 bit grey or RGB, found 16 bit grey");
    EXPECT_EQ(
        decode_infrared_png(as_bytes(bytes_of(scratch / "rgb.png")), "a.png", {20, 10}).error().sentence,
        "a.png: expected 8 or 16 bit grey, found 8 bit RGB");
    EXPECT_THAT(read_depth_png(scratch / "none.png", {20, 10}).error().sentence,
                HasSubstr("none.png: cannot be opened"));
    EXPECT_THAT(read_depth_png(scratch.path(), {20, 10}).error().sentence,
                HasSubstr("expected a regular file"));
    EXPECT_THAT(write_depth_png(image, scratch / "no" / "a.png").error().sentence,
                HasSubstr("a.png: cannot be written"));
}

TEST(DepthPng, EveryCutAndRandomDamageIsRefusedOrReadsAnImageOfTheSize) {
    const ScratchFolder scratch;
    ASSERT_TRUE(write_depth_png(room_image(20, 10, 1), scratch / "good.png"));
    const std::string good = bytes_of(scratch / "good.png");
    // libpng speaks of each damage on standard error; that is not what is tested here.
    const int kept = ::dup(2);
    ASSERT_NE(::freopen("/dev/null", "w", stderr), nullptr);
    std::mt19937 random(9);
    int refused = 0;
    for (size_t trial = 0; trial < good.size() + 2000; ++trial) {
        std::string bytes = good;
        if (trial < good.size()) {
            bytes.resize(trial);
        } else {
            bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
        }
        const std::string exact(bytes.begin(), bytes.end());
        const auto read = decode_depth_png(as_bytes(exact), "a.png", {20, 10});
        if (read && trial < good.size() - 12) ADD_FAILURE() << "a cut of " << trial << " bytes was accepted";
        refused += read ? 0 : 1;
    }
    ::dup2(kept, 2);
    ::close(kept);
    EXPECT_GT(refused, static_cast<int>(good.size()));
}

}  // namespace
}  // namespace deixis
