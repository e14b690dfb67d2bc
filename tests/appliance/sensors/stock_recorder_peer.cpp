// The stock Recorder as a peer: records two virtual devices in one process, as a naive recorder would.
#include <OpenNI.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

/// stock_recorder_peer FOLDER SECONDS: writes FOLDER/left.oni and FOLDER/right.oni with openni::Recorder.
int main(int argc, char** argv) {
    if (argc != 3 || openni::OpenNI::initialize() != openni::STATUS_OK) return 2;
    const std::string names[] = {"left", "right"};
    openni::Device devices[2];
    openni::VideoStream streams[2];
    openni::Recorder recorders[2];
    for (int i = 0; i < 2; ++i) {
        const std::string file = std::string(argv[1]) + "/" + names[i] + ".oni";
        if (devices[i].open(("virtual://" + names[i]).c_str()) != openni::STATUS_OK ||
            streams[i].create(devices[i], openni::SENSOR_DEPTH) != openni::STATUS_OK ||
            recorders[i].create(file.c_str()) != openni::STATUS_OK ||
            recorders[i].attach(streams[i]) != openni::STATUS_OK ||
            recorders[i].start() != openni::STATUS_OK || streams[i].start() != openni::STATUS_OK) {
            std::fprintf(stderr, "%s\n", openni::OpenNI::getExtendedError());
            return 1;
        }
    }
    // The Recorder works on its own threads; how long it records is what is asked for.
    std::this_thread::sleep_for(std::chrono::milliseconds(static_cast<int>(1'000 * std::atof(argv[2]))));
    for (int i = 0; i < 2; ++i) {
        recorders[i].stop();
        streams[i].stop();
        recorders[i].destroy();
    }
    // OpenNI2's player walks its stream list without a lock for a moment after `stop`.
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    for (int i = 0; i < 2; ++i) {
        streams[i].destroy();
        devices[i].close();
    }
    openni::OpenNI::shutdown();
    return 0;
}
