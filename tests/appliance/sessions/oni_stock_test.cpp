// Stock OpenNI2 reads what our writer wrote: every frame, bit for bit, with its stamp.
#include <gtest/gtest.h>

#include "appliance/sessions/oni_writer.h"
#include "tests/appliance/sessions/oni_samples.h"
#include "tests/appliance/sessions/stock_playback.h"

namespace deixis {
namespace {

using namespace testing;  // NOLINT: our own helpers

struct Case {
    std::string name;
    std::vector<DepthImage> images;
    bool infrared = false;
    std::vector<int64_t> stamps = {};
};

/// Images whose end exercises every combination of pending count and waiting nibble.
std::vector<DepthImage> tails() {
    std::vector<DepthImage> images;
    for (int end = 0; end < 64; ++end) {
        DepthImage image = room_image(33, 17, 1);
        for (int i = 0; i < 34; ++i)
            image.millimetres[image.millimetres.size() - 1 - static_cast<size_t>(i)] =
                static_cast<uint16_t>(i <= end % 34 ? 2000 : 2000 + i % 5 + end / 34);
        images.push_back(image);
    }
    return images;
}

std::vector<Case> cases() {
    std::vector<Case> all;
    all.push_back({"odd_size", room_images(33, 17, 20)});
    all.push_back({"vga", room_images(640, 480, 6)});
    all.push_back({"kinect2", room_images(512, 424, 3)});
    all.push_back({"qvga", room_images(320, 240, 3)});
    all.push_back({"hd", room_images(1280, 720, 2)});
    all.push_back({"largest", {noise_image(1600, 1800, 1, 5000)}});
    all.push_back({"one_frame", room_images(64, 48, 1)});
    all.push_back({"one_pixel", {flat_image(1, 1, 65534), flat_image(1, 1, 0)}});
    all.push_back({"thousand", room_images(16, 12, 1000)});
    all.push_back({"tails", tails()});
    all.push_back(
        {"extremes", {flat_image(33, 17, 0), flat_image(33, 17, 65534), noise_image(33, 17, 2, 65534)}});
    all.push_back(
        {"uncoded", {room_image(300, 200, 1), noise_image(300, 200, 3, 65534), room_image(300, 200, 2)}});
    all.push_back({"infrared", {noise_image(64, 48, 4, 65535), room_image(64, 48, 2)}, true});
    all.push_back(
        {"stamps", room_images(16, 12, 5), false, {7, 7, 100, 1'700'000'000'000'000, 1'700'000'000'000'001}});
    return all;
}

TEST(StockOpenNi2, ReadsEveryFrameBitForBit) {
    const ScratchFolder scratch;
    const std::vector<Case> all = cases();
    std::vector<std::filesystem::path> files;
    for (const Case& c : all) {
        files.push_back(scratch / (c.name + ".oni"));
        OniFormat format = oni_format(c.images[0].width, c.images[0].height);
        format.infrared = c.infrared;
        auto writer = OniWriter::create(files.back(), format);
        ASSERT_TRUE(writer) << writer.error().sentence;
        for (size_t i = 0; i < c.images.size(); ++i)
            ASSERT_TRUE(writer->append(c.stamps.empty() ? static_cast<int64_t>(i) * 33'333 : c.stamps[i],
                                       c.images[i]));
        ASSERT_TRUE(writer->finish());
        ASSERT_TRUE(walk_oni(files.back())) << c.name;
    }
    const std::vector<StockPlayback> played = play_with_stock_openni2(files);
    for (size_t i = 0; i < all.size(); ++i) {
        const Case& c = all[i];
        EXPECT_EQ(played[i].status, 0U) << c.name;
        EXPECT_EQ(played[i].width, c.images[0].width) << c.name;
        EXPECT_EQ(played[i].height, c.images[0].height) << c.name;
        EXPECT_NEAR(played[i].horizontal_fov, 1.0, 1e-6) << c.name;
        EXPECT_NEAR(played[i].vertical_fov, 0.75, 1e-6) << c.name;
        EXPECT_EQ(played[i].counted, static_cast<int64_t>(c.images.size())) << c.name;
        ASSERT_EQ(played[i].frames.size(), c.images.size()) << c.name;
        for (size_t f = 0; f < c.images.size(); ++f) {
            const int64_t stamp = c.stamps.empty() ? static_cast<int64_t>(f) * 33'333 : c.stamps[f];
            ASSERT_EQ(played[i].frames[f].timestamp_us, static_cast<uint64_t>(stamp))
                << c.name << " frame " << f;
            ASSERT_EQ(played[i].frames[f].index, f + 1) << c.name << " frame " << f;
            ASSERT_TRUE(played[i].frames[f].image.millimetres == c.images[f].millimetres)
                << c.name << " frame " << f;
        }
    }
}

TEST(StockOpenNi2, ReadsAMendedRecording) {
    const ScratchFolder scratch;
    {
        auto writer = OniWriter::create(scratch / "torn.oni", oni_format(40, 30));
        for (int i = 0; i < 8; ++i)
            ASSERT_TRUE(writer->append(i * 1000, room_image(40, 30, static_cast<uint32_t>(i))));
    }
    std::filesystem::resize_file(scratch / "torn.oni",
                                 std::filesystem::file_size(scratch / "torn.oni") - 100);
    ASSERT_TRUE(mend_recording(scratch / "torn.oni"));
    const StockPlayback played = play_with_stock_openni2({scratch / "torn.oni"})[0];
    EXPECT_EQ(played.status, 0U);
    ASSERT_EQ(played.frames.size(), 7U);
    for (size_t f = 0; f < 7; ++f)
        EXPECT_TRUE(played.frames[f].image.millimetres ==
                    room_image(40, 30, static_cast<uint32_t>(f)).millimetres);
}

TEST(StockOpenNi2, OpensARecordingWithoutFrames) {
    const ScratchFolder scratch;
    auto writer = OniWriter::create(scratch / "empty.oni", oni_format(40, 30));
    ASSERT_TRUE(writer->finish());
    const auto summary = walk_oni(scratch / "empty.oni");
    ASSERT_TRUE(summary) << summary.error().sentence;
    EXPECT_EQ(summary->frames, 0);
    const StockPlayback played = play_with_stock_openni2({scratch / "empty.oni"})[0];
    EXPECT_EQ(played.status, 0U);
    EXPECT_EQ(played.counted, 0);
}

}  // namespace
}  // namespace deixis
