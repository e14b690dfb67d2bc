// timestamps.csv: when each frame of a sensor was taken. Text in, stamps out, and back.
#include "appliance/sessions/frame_stamps.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "appliance/calibration/whole_file.h"

namespace deixis {
namespace {

constexpr size_t largest_file = size_t{1} << 30;

std::string_view trimmed(std::string_view text) {
    const size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// Takes the part before the next `separator` off `rest`.
std::string_view take_until(std::string_view& rest, char separator) {
    const size_t end = std::min(rest.find(separator), rest.size());
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return part;
}

std::optional<int64_t> whole_number(std::string_view text) {
    int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::string shown(std::string_view text) {
    std::string out = "\"";
    for (const char c : text.substr(0, 40)) out += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    return out + "\"";
}

/// The header with the blanks around its fields taken out.
std::string header_of(std::string_view line) {
    std::string out;
    for (const char c : line)
        if (c != ' ' && c != '\t' && c != '\r') out += c;
    return out;
}

}  // namespace

Result<FrameStamps> parse_timestamps(std::string_view text, const std::string& name) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    size_t line_number = 1;
    const auto refuse = [&](const std::string& expected, std::string_view found) {
        return fail(name + ": line " + std::to_string(line_number) + ": expected " + expected + ", found " +
                    shown(found));
    };
    const std::string_view first = take_until(text, '\n');
    const std::string header = header_of(first);
    const bool with_host = header == "frame,timestamp_us,host_us";
    if (!with_host && header != "frame,timestamp_us")
        return refuse("the header frame,timestamp_us or frame,timestamp_us,host_us", trimmed(first));
    FrameStamps stamps;
    while (!trimmed(text).empty() || text.find('\n') != std::string_view::npos) {
        ++line_number;
        const std::string_view line = trimmed(take_until(text, '\n'));
        if (line.empty()) {
            if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) break;  // blank to the end
            return refuse("no empty line between frames", line);
        }
        const auto columns = std::count(line.begin(), line.end(), ',') + 1;
        if (columns != (with_host ? 3 : 2)) return refuse(with_host ? "three columns" : "two columns", line);
        std::string_view rest = line;
        const std::string_view frame = trimmed(take_until(rest, ','));
        const std::string_view stamp = trimmed(take_until(rest, ','));
        if (whole_number(frame) != static_cast<int64_t>(stamps.timestamp_us.size()))
            return refuse("frame " + std::to_string(stamps.timestamp_us.size()), frame);
        const std::optional<int64_t> timestamp_us = whole_number(stamp);
        if (!timestamp_us || *timestamp_us > stamp_limit_us || *timestamp_us < -stamp_limit_us)
            return refuse("a whole number of microseconds", stamp);
        if (!stamps.timestamp_us.empty() && *timestamp_us <= stamps.timestamp_us.back())
            return refuse("a timestamp above " + std::to_string(stamps.timestamp_us.back()), stamp);
        stamps.timestamp_us.push_back(*timestamp_us);
        if (!with_host) continue;
        const std::optional<int64_t> host_us = whole_number(trimmed(rest));
        if (!host_us || *host_us > stamp_limit_us || *host_us < -stamp_limit_us)
            return refuse("a whole number of microseconds", trimmed(rest));
        stamps.host_us.push_back(*host_us);
    }
    return stamps;
}

Result<FrameStamps> read_timestamps(const std::filesystem::path& path) {
    const Result<std::string> text = read_whole_file(path, largest_file);
    if (!text) return tl::unexpected(text.error());
    return parse_timestamps(*text, path.string());
}

const char* timestamps_header(bool with_host) {
    return with_host ? "frame,timestamp_us,host_us\n" : "frame,timestamp_us\n";
}

std::string timestamps_text(const FrameStamps& stamps) {
    const bool with_host = !stamps.host_us.empty();
    std::string out = timestamps_header(with_host);
    for (size_t i = 0; i < stamps.timestamp_us.size(); ++i) {
        out += std::to_string(i);
        out += ',';
        out += std::to_string(stamps.timestamp_us[i]);
        if (with_host) out.append(",").append(std::to_string(stamps.host_us[i]));
        out += '\n';
    }
    return out;
}

std::string frame_file_name(int64_t frame) {
    const std::string digits = std::to_string(frame);
    return std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ".png";
}

}  // namespace deixis
