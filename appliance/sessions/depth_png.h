// Image files of frames folders and sessions: 16-bit grey and 8-bit PNG, checked before they are decoded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// 8-bit picture, row-major: one channel (silhouette) or three interleaved (RGB).
struct VideoImage {
    int width = 0;
    int height = 0;
    int channels = 1;
    std::vector<uint8_t> bytes;
};

/// Size that an image must have; a file that claims another is refused before anything is allocated.
struct ImageSize {
    int width = 0;
    int height = 0;
};

/// 16-bit grey, millimetres. Refuses, in one sentence naming the file, other depths, channels and sizes,
/// damaged or cut files and the value 65535.
Result<DepthImage> read_depth_png(const std::filesystem::path& path, ImageSize size);
Result<DepthImage> decode_depth_png(std::span<const uint8_t> file, const std::string& name, ImageSize size);

/// 8 or 16-bit grey, values unchanged (8 bit stays 0-255).
Result<DepthImage> read_infrared_png(const std::filesystem::path& path, ImageSize size);
Result<DepthImage> decode_infrared_png(std::span<const uint8_t> file, const std::string& name,
                                       ImageSize size);

/// 8-bit RGB, or grey of which every pixel is 0 or 255.
Result<VideoImage> read_video_png(const std::filesystem::path& path, ImageSize size);
Result<VideoImage> decode_video_png(std::span<const uint8_t> file, const std::string& name, ImageSize size);

/// Write so that the readers above give the same image back.
Result<void> write_depth_png(const DepthImage& image, const std::filesystem::path& path);
Result<void> write_video_png(const VideoImage& image, const std::filesystem::path& path);

}  // namespace deixis
