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

Result<void> sync_one(const fs::path& path) {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    const bool done = descriptor >= 0 && ::fsync(descriptor) == 0;
    const std::string reason = std::strerror(errno);
    if (descriptor >= 0) ::close(descriptor);
    return done ? Result<void>{} : fail(path.string() + ": cannot be brought to disk: " + reason);
}

/// Every file and folder below `folder` is on the disk: theirs alone, for syncfs would wait for other
/// programs too.
Result<void> sync_tree(const fs::path& folder) {
    std::error_code error;
    for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error))
        if (auto done = sync_one(entry->path()); !done) return done;
    if (error) return fail(folder.string() + ": cannot be listed: " + error.message());
    return sync_one(folder);
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
    if (auto done = sync_tree(working); !done) return done;
    fs::rename(working, folder, error);
    if (error)
        return fail(working.string() + ": cannot be renamed to " + folder.string() + ": " + error.message());
    fs::remove(folder / "recording.toml",
               error);  // open_session goes by session.toml, so a failure here is harmless
    const fs::path parent = folder.parent_path();
    return sync_folder(parent.empty() ? "." : parent);
}

}  // namespace deixis
