// What stock OpenNI2 delivers of recordings, played in a child process of the test.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "tracking/geometry/depth_image.h"

namespace deixis::testing {

struct StockFrame {
    uint64_t timestamp_us = 0;
    uint32_t index = 0;
    DepthImage image;
};

struct StockPlayback {
    uint32_t status =
        99;  ///< 0 = played whole; the steps of stock_oni_player.cpp otherwise; 99 = the child died
    int width = 0, height = 0, fps = 0;
    int64_t counted = 0;
    double horizontal_fov = 0, vertical_fov = 0;
    std::vector<StockFrame> frames;
};

/// One child for all files.
std::vector<StockPlayback> play_with_stock_openni2(const std::vector<std::filesystem::path>& files);

}  // namespace deixis::testing
