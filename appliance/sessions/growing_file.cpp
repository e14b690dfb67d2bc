// A file that only grows: what is written at its end is there whole or not at all.
#include "appliance/sessions/growing_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace deixis {

GrowingFile::GrowingFile(std::filesystem::path path) : path_(std::move(path)) {}

GrowingFile::~GrowingFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> GrowingFile::open(int flags, uint64_t end) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CLOEXEC | flags, 0644);
    end_ = end;
    return descriptor_ < 0 ? refuse("cannot be opened") : Result<void>{};
}

Result<void> GrowingFile::append(std::span<const uint8_t> first, std::span<const uint8_t> second) {
    const uint64_t before = end_;
    if (write_at_end(first) && write_at_end(second)) return {};
    const int reason = errno;
    end_ = before;
    // Best effort: should even this fail, the mender cuts the torn record.
    static_cast<void>(::ftruncate(descriptor_, static_cast<off_t>(before)) == 0);
    errno = reason;
    return refuse("cannot be written");
}

Result<void> GrowingFile::patch(uint64_t at, std::span<const uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(at));
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return refuse("cannot be written");
        at += static_cast<uint64_t>(written);
        bytes = bytes.subspan(static_cast<size_t>(written));
    }
    return {};
}

Result<void> GrowingFile::cut(uint64_t end) {
    if (::ftruncate(descriptor_, static_cast<off_t>(end)) != 0) return refuse("cannot be cut");
    end_ = end;
    return {};
}

Result<void> GrowingFile::sync() {
    return ::fsync(descriptor_) == 0 ? Result<void>{} : refuse("cannot be brought to disk");
}

Result<void> GrowingFile::rename_to(const std::filesystem::path& path) {
    if (::rename(path_.c_str(), path.c_str()) != 0) return refuse("cannot be renamed");
    path_ = path;
    return {};
}

bool GrowingFile::write_at_end(std::span<const uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(end_));
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        end_ += static_cast<uint64_t>(written);
        bytes = bytes.subspan(static_cast<size_t>(written));
    }
    return true;
}

tl::unexpected<Failure> GrowingFile::refuse(const char* what) const {
    return fail(path_.string() + ": " + what + ": " + std::strerror(errno));
}

}  // namespace deixis
