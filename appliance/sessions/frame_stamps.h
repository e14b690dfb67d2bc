// timestamps.csv: when each frame of a sensor was taken. Text in, stamps out, and back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

/// No stamp is larger, forwards or backwards: sums and differences of two stay in 64 bits.
constexpr int64_t stamp_limit_us = int64_t{1} << 61;

/// One entry a frame.
struct FrameStamps {
    std::vector<int64_t> timestamp_us;  ///< strictly rising
    std::vector<int64_t> host_us;       ///< empty when the file has no such column
};

/// Header `frame,timestamp_us` or `frame,timestamp_us,host_us`, frames from 0 without gaps. A byte order
/// mark, CRLF, blanks around fields and empty last lines pass; everything else is refused, naming `name` and
/// line.
Result<FrameStamps> parse_timestamps(std::string_view text, const std::string& name);
Result<FrameStamps> read_timestamps(const std::filesystem::path& path);

/// The first line, with its line feed.
const char* timestamps_header(bool with_host);

/// The file that `parse_timestamps` reads back; the host column stands where `host_us` is not empty.
std::string timestamps_text(const FrameStamps& stamps);

/// "000042.png", the image of frame 42.
std::string frame_file_name(int64_t frame);

}  // namespace deixis
