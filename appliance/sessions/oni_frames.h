// The frame records of a recording, one after the other, checked and decoded; shared by walker and mender.
#pragma once

#include <cstdint>
#include <string>

#include "appliance/sessions/oni_bytes.h"
#include "appliance/sessions/oni_head.h"
#include "tracking/geometry/depth_image.h"

namespace deixis::oni {

/// Steps from frame record to frame record. The image buffer is reused.
class FrameReader {
  public:
    FrameReader(OniBytes& bytes, const std::string& name, const Head& head);

    /// Reads the next record if it is a frame; `false`: another record stands there (`at()`). Refuses a frame
    /// whose number, stamp, size or (with `decode`) pixels are wrong.
    Result<bool> next(bool decode);

    uint64_t at() const { return at_; }              ///< of the record to read next
    uint64_t frame_at() const { return frame_at_; }  ///< of the frame last read
    int64_t frames() const { return frames_; }       ///< read so far
    int64_t timestamp_us() const { return timestamp_us_; }
    const DepthImage& image() const { return image_; }

  private:
    OniBytes& bytes_;
    const std::string& name_;
    Head head_;
    uint64_t at_;
    uint64_t frame_at_ = 0;
    int64_t frames_ = 0;
    int64_t timestamp_us_ = 0;
    DepthImage image_;
};

}  // namespace deixis::oni
