// What stock OpenNI2 delivers of recordings, played in a child process of the test.
#include "tests/appliance/sessions/stock_playback.h"

#include <cstdio>
#include <string>

namespace deixis::testing {
namespace {

template <class T>
bool take(FILE* in, T& value) {
    return std::fread(&value, sizeof value, 1, in) == 1;
}

bool take_playback(FILE* in, StockPlayback& playback) {
    uint32_t width = 0;
    uint32_t height = 0;
    uint32_t fps = 0;
    int64_t delivered = 0;
    if (!take(in, playback.status) || !take(in, width) || !take(in, height) || !take(in, fps)) return false;
    if (!take(in, playback.counted) || !take(in, playback.horizontal_fov) || !take(in, playback.vertical_fov))
        return false;
    if (!take(in, delivered)) return false;
    playback.width = static_cast<int>(width);
    playback.height = static_cast<int>(height);
    playback.fps = static_cast<int>(fps);
    for (int64_t i = 0; i < delivered; ++i) {
        StockFrame frame;
        frame.image.resize(playback.width, playback.height);
        std::vector<uint16_t>& pixels = frame.image.millimetres;
        if (!take(in, frame.timestamp_us) || !take(in, frame.index)) return false;
        if (std::fread(pixels.data(), 2, pixels.size(), in) != pixels.size()) return false;
        playback.frames.push_back(std::move(frame));
    }
    return true;
}

}  // namespace

std::vector<StockPlayback> play_with_stock_openni2(const std::vector<std::filesystem::path>& files) {
    std::string command = STOCK_ONI_PLAYER;
    for (const auto& file : files) command.append(" '").append(file.string()).append("'");
    std::vector<StockPlayback> playbacks(files.size());
    FILE* in = ::popen(command.c_str(), "r");
    if (in == nullptr) return playbacks;
    for (StockPlayback& playback : playbacks)
        if (!take_playback(in, playback)) break;
    ::pclose(in);
    return playbacks;
}

}  // namespace deixis::testing
