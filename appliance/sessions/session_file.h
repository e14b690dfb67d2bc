// session.toml as text: written by the session writer, parsed by `parse_session`.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include "appliance/sessions/session.h"

namespace deixis {

/// A TOML file of a session that is larger is not read.
constexpr size_t largest_toml = size_t{1} << 20;

constexpr const char* session_format = "deixis-session/1";

/// `recording.toml` of an unfinished session: the same keys, frames and checksums not yet known.
constexpr const char* recording_format = "deixis-recording/1";

/// `session.streams[i].file` is written as its file name. Read back by `parse_session` of the same format.
std::string session_text(const Session& session, const std::map<std::string, std::string>& tools,
                         const char* format);

struct SessionText {
    Session session;  ///< streams in the file's order, `file` and `host_times` as names without a folder
    std::map<std::string, std::string> tools;
};
Result<SessionText> parse_session_text(std::string_view toml, const std::string& name, const char* format);

}  // namespace deixis
