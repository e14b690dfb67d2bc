// Temporary name, sync, rename, sync of the folder: the order that survives a power cut.
#include "appliance/exports/export_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace deixis {
namespace {

bool write_all(int file, std::string_view text) {
    while (!text.empty()) {
        const ssize_t written = ::write(file, text.data(), text.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return false;
        text.remove_prefix(static_cast<size_t>(written));
    }
    return true;
}

}  // namespace

Result<void> write_export_file(const std::filesystem::path& path, std::string_view text) {
    const auto refused = [&](int code) {
        return fail("cannot write " + path.string() + ": " + std::strerror(code));
    };
    std::error_code trouble;
    if (std::filesystem::is_directory(path, trouble)) return refused(EISDIR);
    const std::string temporary = path.string() + ".partial-" + std::to_string(::getpid());
    const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file < 0) return refused(errno);
    bool whole = write_all(file, text) && ::fsync(file) == 0;
    int code = errno;
    if (::close(file) != 0 && whole) {
        whole = false;
        code = errno;
    }
    if (whole && ::rename(temporary.c_str(), path.c_str()) != 0) {
        whole = false;
        code = errno;
    }
    if (!whole) {
        ::unlink(temporary.c_str());
        return refused(code);
    }
    const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    const int folder_file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder_file >= 0) {
        ::fsync(folder_file);  // some file systems cannot; the file itself is synced
        ::close(folder_file);
    }
    return {};
}

}  // namespace deixis
