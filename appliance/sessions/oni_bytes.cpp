// The bytes of a recording, in a file or in memory, a window at a time.
#include "appliance/sessions/oni_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace deixis {
namespace {

/// Small windows are cut from reads of this size, so that a walk over records does not make one call a field.
constexpr size_t read_ahead = size_t{1} << 18;

size_t read_fully(int descriptor, uint64_t offset, uint8_t* out, size_t count) {
    size_t done = 0;
    while (done < count) {
        const ssize_t got = ::pread(descriptor, out + done, count - done, static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        done += static_cast<size_t>(got);
    }
    return done;
}

}  // namespace

Result<OniBytes> OniBytes::open(const std::filesystem::path& path) {
    OniBytes bytes;
    // O_NONBLOCK: a named pipe in place of the recording must not hold us up.
    bytes.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (bytes.descriptor_ < 0) return fail(path.string() + ": cannot be opened: " + std::strerror(errno));
    struct stat status = {};
    if (::fstat(bytes.descriptor_, &status) != 0 || !S_ISREG(status.st_mode))
        return fail(path.string() + ": expected a regular file");
    bytes.size_ = static_cast<uint64_t>(status.st_size);
    return bytes;
}

OniBytes::OniBytes(std::span<const uint8_t> memory) : size_(memory.size()), memory_(memory) {}

OniBytes::OniBytes(OniBytes&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_),
      memory_(other.memory_),
      buffer_(std::move(other.buffer_)),
      buffer_at_(other.buffer_at_),
      buffered_(std::exchange(other.buffered_, 0)) {}

OniBytes::~OniBytes() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

std::optional<std::span<const uint8_t>> OniBytes::window(uint64_t offset, size_t count) {
    if (offset > size_ || count > size_ - offset) return std::nullopt;
    if (descriptor_ < 0) return memory_.subspan(offset, count);
    if (offset < buffer_at_ || offset + count > buffer_at_ + buffered_) {
        const size_t wanted =
            static_cast<size_t>(std::min<uint64_t>(std::max(count, read_ahead), size_ - offset));
        if (buffer_.size() < wanted) buffer_.resize(wanted);
        buffer_at_ = offset;
        buffered_ = read_fully(descriptor_, offset, buffer_.data(), wanted);
        if (buffered_ < count) return std::nullopt;  // the file shrank, or the disk cannot be read
    }
    return std::span<const uint8_t>(buffer_).subspan(offset - buffer_at_, count);
}

std::optional<uint64_t> OniBytes::first_nonzero(uint64_t offset) {
    while (offset < size_) {
        if (descriptor_ >= 0) {
            const off_t data = ::lseek(descriptor_, static_cast<off_t>(offset), SEEK_DATA);
            if (data < 0 && errno == ENXIO) return std::nullopt;
            if (data > 0) offset = static_cast<uint64_t>(data);
        }
        const size_t count = static_cast<size_t>(std::min<uint64_t>(read_ahead, size_ - offset));
        const auto bytes = window(offset, count);
        if (!bytes) return offset;
        const auto found = std::find_if(bytes->begin(), bytes->end(), [](uint8_t byte) { return byte != 0; });
        if (found != bytes->end()) return offset + static_cast<uint64_t>(found - bytes->begin());
        offset += count;
    }
    return std::nullopt;
}

}  // namespace deixis
