// The last steps of a session folder, after recording or mending: checksums, session.toml, disk, rename.
#include "appliance/sessions/session_seal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "appliance/calibration/whole_file.h"
#include "appliance/sessions/session_file.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;

/// Everything written so far is on the disk.
Result<void> sync_file_system(const fs::path& folder) {
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool done = descriptor >= 0 && ::syncfs(descriptor) == 0;
    const std::string reason = std::strerror(errno);
    if (descriptor >= 0) ::close(descriptor);
    return done ? Result<void>{} : fail(folder.string() + ": cannot be brought to disk: " + reason);
}

}  // namespace

Result<void> seal_session(Session& session, const std::map<std::string, std::string>& tools,
                          const fs::path& working, const fs::path& folder) {
    for (SessionStream& stream : session.streams) {
        const Result<std::string> checksum = stream_checksum(working / stream.file);
        if (!checksum) return tl::unexpected(checksum.error());
        stream.checksum = *checksum;
    }
    if (auto done = write_whole_file(working / "session.toml", session_text(session, tools, session_format));
        !done)
        return done;
    std::error_code error;
    if (fs::exists(folder, error)) return fail(folder.string() + ": exists already");
    if (auto done = sync_file_system(working); !done) return done;
    fs::rename(working, folder, error);
    if (error)
        return fail(working.string() + ": cannot be renamed to " + folder.string() + ": " + error.message());
    fs::remove(folder / "recording.toml",
               error);  // open_session goes by session.toml, so a failure here is harmless
    const fs::path parent = folder.parent_path();
    return sync_folder(parent.empty() ? "." : parent);
}

}  // namespace deixis
