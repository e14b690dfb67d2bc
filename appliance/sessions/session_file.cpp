// session.toml as text: written by the session writer, parsed by `parse_session`.
#include "appliance/sessions/session_file.h"

#include <algorithm>
#include <set>

#include "appliance/calibration/toml_section.h"
#include "appliance/sessions/frame_stamps.h"

namespace deixis {
namespace {

constexpr std::string_view checksum_start = "xxh3-64:";

/// A file of the session folder itself: no way out of it.
bool is_plain_name(const std::string& name) {
    const auto unusable = [](char c) {
        return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    };
    return !name.empty() && name.size() <= 255 && name.front() != '.' &&
           std::none_of(name.begin(), name.end(), unusable);
}

bool is_checksum(std::string_view text) {
    return text.size() == checksum_start.size() + 16 && text.starts_with(checksum_start) &&
           text.find_first_not_of("0123456789abcdef", checksum_start.size()) == std::string_view::npos;
}

std::string file_name_key(TomlSection& section, std::string_view key) {
    constexpr const char* expected = "the name of a file in the session folder";
    std::string name = section.text(key, expected);
    if (!is_plain_name(name)) section.refuse(key, expected, toml_quoted(name));
    return name;
}

SessionStream read_stream(TomlSection& section, std::set<std::string>& sensors, bool finished) {
    SessionStream stream;
    stream.sensor = section.text("sensor", "the name of a sensor in calibration.toml");
    if (!sensors.insert(stream.sensor).second)
        section.refuse("sensor", "a sensor that has no stream yet", toml_quoted(stream.sensor));
    stream.file = file_name_key(section, "file");
    stream.start_us = section.whole_number("start_us", -stamp_limit_us, stamp_limit_us);
    if (section.has("host_times")) stream.host_times = file_name_key(section, "host_times");
    section.ignore("host_times");
    if (finished) {
        stream.frames = section.whole_number("frames", 0, int64_t{0xFFFFFFFE});
        constexpr const char* expected = "\"xxh3-64:\" and 16 hexadecimal digits";
        stream.checksum = section.text("checksum", expected);
        if (!is_checksum(stream.checksum)) section.refuse("checksum", expected, toml_quoted(stream.checksum));
    }
    section.warn_of_unknown_keys();
    return stream;
}

}  // namespace

std::string session_text(const Session& session, const std::map<std::string, std::string>& tools,
                         const char* format) {
    std::string out = "format = " + toml_quoted(format) + "\n";
    out += "name = " + toml_quoted(session.name) + "\ncreated = " + toml_quoted(session.created) +
           "\n\n[tools]\n";
    for (const auto& [tool, version] : tools) out += toml_quoted(tool) + " = " + toml_quoted(version) + "\n";
    for (const SessionStream& stream : session.streams) {
        out += "\n[[stream]]\nsensor = " + toml_quoted(stream.sensor) + "\n";
        out += "file = " + toml_quoted(stream.file.filename().string()) + "\n";
        out += "start_us = " + std::to_string(stream.start_us) + "\n";
        if (!stream.checksum.empty()) {
            out += "frames = " + std::to_string(stream.frames) + "\n";
            out += "checksum = " + toml_quoted(stream.checksum) + "\n";
        }
        if (stream.host_times)
            out += "host_times = " + toml_quoted(stream.host_times->filename().string()) + "\n";
    }
    return out;
}

Result<SessionText> parse_session_text(std::string_view toml, const std::string& name, const char* format) {
    const Result<toml::table> table = parse_toml(toml, name);
    if (!table) return tl::unexpected(table.error());
    TomlComplaints complaints{name, {}, {}};
    TomlSection top(*table, "", complaints);
    SessionText text;
    const std::string expected = toml_quoted(format);
    const std::string found = top.text("format", expected.c_str());
    if (found != format) top.refuse("format", expected, toml_quoted(found));
    text.session.name = top.text("name", "the session's name");
    text.session.created = top.utc_time("created");
    if (std::optional<TomlSection> tools = top.table("tools"))
        for (const std::string& tool : tools->keys())
            text.tools[tool] = tools->text(tool, "a version in quotes");
    std::set<std::string> sensors;
    std::vector<TomlSection> streams = top.tables("stream");
    if (streams.empty() || streams.size() > 64) top.refuse("stream", "1 to 64 tables headed [[stream]]");
    for (TomlSection& section : streams) {
        if (complaints.first) break;
        text.session.streams.push_back(
            read_stream(section, sensors, format == std::string_view(session_format)));
    }
    top.warn_of_unknown_keys();
    if (complaints.first) return tl::unexpected(*complaints.first);
    text.session.warnings = std::move(complaints.warnings);
    return text;
}

Result<Session> parse_session(std::string_view toml, const std::string& name) {
    Result<SessionText> text = parse_session_text(toml, name, session_format);
    if (!text) return tl::unexpected(text.error());
    return std::move(text->session);
}

}  // namespace deixis
