// One depth stream of OpenNI2, device or recording, read on one thread with timed waits. Frames out, or a
// sentence.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

struct OpenniFrame {
    int64_t timestamp_us = 0;
    std::vector<uint16_t> millimetres;
};

/// To be used by one object a process, on the thread that made it (OpenNI2 shares state between files and
/// threads).
class OpenniReader {
  public:
    enum class Read { frame, nothing, failed };

    /// Opens and starts a stream of this size in millimetres. A recording is played frame by frame on
    /// request, without seeking; a live device is told not to mirror. Refuses, naming `uri`: no such device,
    /// no depth stream, another size or pixel format, another number of frames than `expected_frames`
    /// (recordings).
    static Result<OpenniReader> open(const std::string& uri, bool recording, int width, int height,
                                     int64_t expected_frames);
    OpenniReader(OpenniReader&&) noexcept;
    OpenniReader& operator=(OpenniReader&&) noexcept;
    ~OpenniReader();  ///< closes

    /// The next frame, waiting at most `patience`. `failed`: the device went away or sends something else,
    /// see `failure`.
    Read read(OpenniFrame& out, std::chrono::milliseconds patience);
    const std::string& failure() const;

    /// Stops, waits out OpenNI2's player thread, closes, shuts OpenNI2 down. To be called right after the
    /// last frame of a recording: from there on the player would spin.
    void close();

  private:
    struct Impl;
    explicit OpenniReader(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace deixis
