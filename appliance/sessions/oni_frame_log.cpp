// The frames written so far, as the records after them need to know them, and those records.
#include "appliance/sessions/oni_frame_log.h"

#include <algorithm>
#include <cmath>

namespace deixis::oni {

FrameLog::FrameLog() : seek_entries(seek_entry_bytes, 0) {}

void FrameLog::add(int64_t timestamp_us, uint64_t at) {
    if (frames == 0) first_us = timestamp_us;
    ++frames;
    last_us = timestamp_us;
    last_at = at;
    if (frames > longest_seek_table) {
        seek_entries = {};
        return;
    }
    put<uint64_t>(seek_entries, static_cast<uint64_t>(timestamp_us));
    put<uint32_t>(seek_entries, 0);
    put<uint64_t>(seek_entries, at);
}

std::vector<uint8_t> frame_head(const FrameLog& log, int64_t timestamp_us, size_t payload_bytes) {
    std::vector<uint8_t> out;
    put_record_head(out, new_data, only_node, new_data_bytes, payload_bytes, log.last_at);
    put<uint64_t>(out, static_cast<uint64_t>(timestamp_us));
    put<uint32_t>(out, static_cast<uint32_t>(log.frames + 1));
    return out;
}

Result<void> close_records(GrowingFile& file, const FrameLog& log, Head& head) {
    std::vector<uint8_t> tail;
    put_record_head(tail, node_removed, only_node, record_head_bytes, 0, file_header_bytes);
    head.seek_table_at = 0;
    if (log.frames <= longest_seek_table) {
        head.seek_table_at = file.end() + tail.size();
        put_record_head(tail, seek_table, only_node, record_head_bytes, log.seek_entries.size(), 0);
        tail.insert(tail.end(), log.seek_entries.begin(), log.seek_entries.end());
    }
    put_record_head(tail, end_record, 0, record_head_bytes, 0, 0);
    head.frames = static_cast<uint32_t>(log.frames);
    head.node_last_us = static_cast<uint64_t>(log.last_us);
    head.header_last_us = head.node_last_us;
    return file.append(tail, {});
}

int fps_of(const FrameLog& log) {
    const int64_t span_us = log.last_us - log.first_us;
    if (span_us <= 0) return assumed_fps;
    const double fps = static_cast<double>(log.frames - 1) * 1e6 / static_cast<double>(span_us);
    return static_cast<int>(std::clamp(std::round(fps), 1.0, 1000.0));
}

}  // namespace deixis::oni
