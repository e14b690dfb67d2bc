// The strict look at an .oni recording before OpenNI2 may open it, and our own reader. File or bytes in,
// frames out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "appliance/sessions/depth_codec.h"
#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// What the records of a recording say.
struct OniSummary {
    int width = 0;
    int height = 0;
    int fps = 0;
    bool infrared = false;
    OniCodec codec = OniCodec::table;
    double horizontal_fov = 0;  ///< [rad]; 0 = not recorded
    double vertical_fov = 0;
    int64_t frames = 0;
    int64_t first_us = 0;  ///< stamps as in the file
    int64_t last_us = 0;
    uint64_t data_bytes = 0;  ///< up to the end of the end record; beyond it there are only zeros
};

/// Called for each frame in order, `frame` from 0; the image is valid during the call. False stops the
/// reading.
using OniFrameCallback = std::function<bool(int64_t frame, int64_t timestamp_us, const DepthImage& image)>;

enum class OniPixels {
    decoded,
    skipped
};  ///< skipped: headers only, for files whose checksum has been verified

/// Walks every record and refuses, naming byte offset and expectation, whatever OpenNI2 does not play whole:
/// the list under "Before OpenNI2 opens a file" of oni-format. Bounded memory: nothing is allocated on a
/// file's word. A tail of zeros after the end record (the stock Recorder leaves one) passes. A recording that
/// was not closed is refused with the advice to mend it.
Result<OniSummary> walk_oni(const std::filesystem::path& path, OniPixels pixels = OniPixels::decoded);

/// The same for a file in memory; `name` stands in the sentences.
Result<OniSummary> walk_oni(std::span<const uint8_t> bytes, const std::string& name,
                            OniPixels pixels = OniPixels::decoded);

/// Only the head, up to the first frame record: size, frame count, codec. `first_us` and `data_bytes` stay 0.
Result<OniSummary> read_oni_head(const std::filesystem::path& path);

/// Walks and decodes; frames before a fault have been delivered when the failure comes back.
Result<OniSummary> read_oni(const std::filesystem::path& path, const OniFrameCallback& each);
Result<OniSummary> read_oni(std::span<const uint8_t> bytes, const std::string& name,
                            const OniFrameCallback& each);

}  // namespace deixis
