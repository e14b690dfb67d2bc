// Recordings for tests: written by our writer, as files and as bytes.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/oni_writer.h"
#include "tests/appliance/sessions/sample_images.h"
#include "tests/appliance/sessions/scratch_folder.h"

namespace deixis::testing {

inline OniFormat oni_format(int width, int height) {
    OniFormat format;
    format.width = width;
    format.height = height;
    format.horizontal_fov = 1.0;
    format.vertical_fov = 0.75;
    return format;
}

/// Frame i at i * 33333 us.
inline void write_recording(const std::filesystem::path& path, const std::vector<DepthImage>& images) {
    auto writer = OniWriter::create(path, oni_format(images[0].width, images[0].height));
    ASSERT_TRUE(writer) << writer.error().sentence;
    for (size_t i = 0; i < images.size(); ++i) {
        const auto done = writer->append(static_cast<int64_t>(i) * 33'333, images[i]);
        ASSERT_TRUE(done) << done.error().sentence;
    }
    const auto done = writer->finish();
    ASSERT_TRUE(done) << done.error().sentence;
}

inline std::vector<DepthImage> room_images(int width, int height, int count) {
    std::vector<DepthImage> images;
    for (int i = 0; i < count; ++i) images.push_back(room_image(width, height, static_cast<uint32_t>(i)));
    return images;
}

/// A recording of `count` small frames as the bytes of its file.
inline std::string small_recording(int count) {
    const ScratchFolder scratch;
    write_recording(scratch / "small.oni", room_images(8, 6, count));
    return bytes_of(scratch / "small.oni");
}

inline std::span<const uint8_t> as_bytes(const std::string& text) {
    return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

struct ReadFrame {
    int64_t timestamp_us;
    DepthImage image;
};

inline std::vector<ReadFrame> frames_of(const std::filesystem::path& path) {
    std::vector<ReadFrame> frames;
    const auto read = read_oni(path, [&](int64_t frame, int64_t timestamp_us, const DepthImage& image) {
        EXPECT_EQ(frame, static_cast<int64_t>(frames.size()));
        frames.push_back({timestamp_us, image});
        return true;
    });
    EXPECT_TRUE(read) << read.error().sentence;
    return frames;
}

}  // namespace deixis::testing
