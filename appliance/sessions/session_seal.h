// The last steps of a session folder, after recording or mending: checksums, session.toml, disk, rename.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "appliance/sessions/session.h"

namespace deixis {

/// Streams of `session` name files inside `working`; their checksums are filled in. Refuses an existing
/// `folder`.
Result<void> seal_session(Session& session, const std::map<std::string, std::string>& tools,
                          const std::filesystem::path& working, const std::filesystem::path& folder);

}  // namespace deixis
