// Plays recordings with stock OpenNI2 and writes what it delivers to standard output: the judge of our
// writer.
//
//   stock_oni_player FILE...
//
// For each file: u32 status (0 = read whole), u32 width, height, fps, i64 frames that OpenNI2 counts, f64
// horizontal and vertical field of view, i64 frames delivered; then for each of those u64 stamp, u32 frame
// index and the pixels.
#include <OpenNI.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <thread>
#include <vector>

namespace {

struct PlayedFile {
    uint32_t status = 0, width = 0, height = 0, fps = 0;
    int64_t counted = 0;
    double horizontal_fov = 0, vertical_fov = 0;
    std::vector<uint8_t> frames;
    int64_t delivered = 0;
};

template <class T>
void append(std::vector<uint8_t>& out, const T& value) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(&value);
    out.insert(out.end(), bytes, bytes + sizeof value);
}

void read_frames(openni::VideoStream& stream, PlayedFile& played) {
    for (int64_t i = 0; i < played.counted; ++i) {
        // readFrame blocks for ever at the end of a file, so never without a wait that ends.
        openni::VideoStream* streams[] = {&stream};
        int ready = -1;
        if (openni::OpenNI::waitForAnyStream(streams, 1, &ready, 3000) != openni::STATUS_OK) {
            played.status = 6;
            return;
        }
        openni::VideoFrameRef frame;
        if (stream.readFrame(&frame) != openni::STATUS_OK) {
            played.status = 7;
            return;
        }
        append(played.frames, static_cast<uint64_t>(frame.getTimestamp()));
        append(played.frames, static_cast<uint32_t>(frame.getFrameIndex()));
        const auto* pixels = static_cast<const uint8_t*>(frame.getData());
        played.frames.insert(played.frames.end(), pixels, pixels + frame.getDataSize());
        ++played.delivered;
    }
}

PlayedFile play(const char* path) {
    PlayedFile played;
    openni::Device device;
    if (device.open(path) != openni::STATUS_OK) {
        played.status = 1;
        return played;
    }
    const bool infrared = !device.hasSensor(openni::SENSOR_DEPTH);
    openni::VideoStream stream;
    if (stream.create(device, infrared ? openni::SENSOR_IR : openni::SENSOR_DEPTH) != openni::STATUS_OK) {
        played.status = 2;
        return played;
    }
    const openni::VideoMode mode = stream.getVideoMode();
    played.width = static_cast<uint32_t>(mode.getResolutionX());
    played.height = static_cast<uint32_t>(mode.getResolutionY());
    played.fps = static_cast<uint32_t>(mode.getFps());
    played.horizontal_fov = static_cast<double>(stream.getHorizontalFieldOfView());
    played.vertical_fov = static_cast<double>(stream.getVerticalFieldOfView());
    const openni::PixelFormat wanted =
        infrared ? openni::PIXEL_FORMAT_GRAY16 : openni::PIXEL_FORMAT_DEPTH_1_MM;
    if (mode.getPixelFormat() != wanted) played.status = 3;
    openni::PlaybackControl* control = device.getPlaybackControl();
    control->setRepeatEnabled(false);
    control->setSpeed(-1);
    played.counted = control->getNumberOfFrames(stream);
    if (played.counted < 0) played.status = 4;
    if (stream.start() != openni::STATUS_OK) played.status = 5;
    if (played.status == 0) read_frames(stream, played);
    // The player's own thread walks the stream list unlocked: let it come to rest first.
    stream.stop();
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    stream.destroy();
    device.close();
    return played;
}

}  // namespace

int main(int argc, char** argv) {
    if (openni::OpenNI::initialize() != openni::STATUS_OK) {
        std::fprintf(stderr, "%s\n", openni::OpenNI::getExtendedError());
        return 1;
    }
    for (int i = 1; i < argc; ++i) {
        const PlayedFile played = play(argv[i]);
        std::vector<uint8_t> out;
        for (const uint32_t number : {played.status, played.width, played.height, played.fps})
            append(out, number);
        append(out, played.counted);
        append(out, played.horizontal_fov);
        append(out, played.vertical_fov);
        append(out, played.delivered);
        std::fwrite(out.data(), 1, out.size(), stdout);
        std::fwrite(played.frames.data(), 1, played.frames.size(), stdout);
    }
    std::fflush(stdout);
    _exit(0);  // shutting the hardware drivers down takes half a second and proves nothing here
}
