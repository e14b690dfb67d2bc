// The frames written so far, as the records after them need to know them, and those records.
#pragma once

#include <cstdint>
#include <vector>

#include "appliance/sessions/growing_file.h"
#include "appliance/sessions/oni_head.h"
#include "appliance/sessions/oni_layout.h"

namespace deixis::oni {

struct FrameLog {
    int64_t frames = 0;
    int64_t first_us = 0;
    int64_t last_us = 0;
    uint64_t last_at = 0;  ///< of the last frame's record; 0 = none
    std::vector<uint8_t>
        seek_entries;  ///< payload of the seek table; empty when there are too many frames for one

    FrameLog();
    void add(int64_t timestamp_us, uint64_t at);
};

/// Head and fields of the next frame's record.
std::vector<uint8_t> frame_head(const FrameLog& log, int64_t timestamp_us, size_t payload_bytes);

/// Writes node removed, seek table and end behind the frames; `head` then says where and how many.
Result<void> close_records(GrowingFile& file, const FrameLog& log, Head& head);

/// From the stamps, 1 to 1000; 30 where they do not tell.
int fps_of(const FrameLog& log);
constexpr int assumed_fps = 30;

}  // namespace deixis::oni
