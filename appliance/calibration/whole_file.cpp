// A small file as one string: read with a limit, written all or not at all.
#include "appliance/calibration/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace deixis {
namespace {

std::string system_reason() {
    return std::strerror(errno);
}

/// Closes on every way out.
struct OpenFile {
    int descriptor = -1;
    explicit OpenFile(int d) : descriptor(d) {}
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    ~OpenFile() {
        if (descriptor >= 0) ::close(descriptor);
    }
};

}  // namespace

Result<std::string> read_whole_file(const std::filesystem::path& path, size_t limit) {
    // O_NONBLOCK: a named pipe in place of the file must not hold us up.
    const OpenFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.descriptor < 0) return fail(path.string() + ": cannot be opened: " + system_reason());
    struct stat status = {};
    if (::fstat(file.descriptor, &status) != 0 || !S_ISREG(status.st_mode))
        return fail(path.string() + ": expected a regular file");
    std::string bytes;
    while (bytes.size() <= limit) {
        const size_t before = bytes.size();
        bytes.resize(before + std::min<size_t>(limit + 1 - before, size_t{1} << 16));
        const ssize_t got = ::read(file.descriptor, bytes.data() + before, bytes.size() - before);
        if (got < 0 && errno != EINTR) return fail(path.string() + ": cannot be read: " + system_reason());
        bytes.resize(before + static_cast<size_t>(std::max<ssize_t>(got, 0)));
        if (got == 0) return bytes;
    }
    return fail(path.string() + ": expected at most " + std::to_string(limit) + " bytes");
}

Result<void> write_whole_file(const std::filesystem::path& path, std::string_view bytes) {
    const std::filesystem::path beside = path.string() + ".new";
    const auto refuse = [&]() -> Result<void> {
        const std::string reason = system_reason();
        ::unlink(beside.c_str());
        return fail(path.string() + ": cannot be written: " + reason);
    };
    {
        const OpenFile file(::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
        if (file.descriptor < 0) return refuse();
        while (!bytes.empty()) {
            const ssize_t written = ::write(file.descriptor, bytes.data(), bytes.size());
            if (written < 0 && errno == EINTR) continue;
            if (written < 0) return refuse();
            bytes.remove_prefix(static_cast<size_t>(written));
        }
        if (::fsync(file.descriptor) != 0) return refuse();
    }
    if (::rename(beside.c_str(), path.c_str()) != 0) return refuse();
    return {};
}

Result<void> sync_folder(const std::filesystem::path& folder) {
    const OpenFile file(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (file.descriptor < 0 || ::fsync(file.descriptor) != 0)
        return fail(folder.string() + ": cannot be brought to disk: " + system_reason());
    return {};
}

}  // namespace deixis
