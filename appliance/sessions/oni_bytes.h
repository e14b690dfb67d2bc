// The bytes of a recording, in a file or in memory, a window at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

/// Random access with one buffer, as large as the largest window asked for. Not for several threads.
class OniBytes {
  public:
    /// Refuses what is not a regular file that can be read.
    static Result<OniBytes> open(const std::filesystem::path& path);
    explicit OniBytes(std::span<const uint8_t> memory);
    OniBytes(OniBytes&& other) noexcept;
    OniBytes& operator=(OniBytes&&) = delete;
    ~OniBytes();

    uint64_t size() const { return size_; }

    /// `count` bytes from `offset`, valid until the next call; nothing when they are not all there.
    std::optional<std::span<const uint8_t>> window(uint64_t offset, size_t count);

    /// Offset of the first byte at or after `offset` that is not zero; nothing when there is none. Skips
    /// holes of sparse files.
    std::optional<uint64_t> first_nonzero(uint64_t offset);

  private:
    OniBytes() = default;

    int descriptor_ = -1;
    uint64_t size_ = 0;
    std::span<const uint8_t> memory_;
    std::vector<uint8_t> buffer_;
    uint64_t buffer_at_ = 0;  // the buffer holds the file from here
    size_t buffered_ = 0;
};

}  // namespace deixis
