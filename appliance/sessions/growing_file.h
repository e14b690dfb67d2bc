// A file that only grows: what is written at its end is there whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "tracking/geometry/result.h"

namespace deixis {

/// Every failure names the file and the system's reason.
class GrowingFile {
  public:
    explicit GrowingFile(std::filesystem::path path);
    GrowingFile(const GrowingFile&) = delete;
    GrowingFile& operator=(const GrowingFile&) = delete;
    ~GrowingFile();

    /// `flags` of open(2) besides O_RDWR; the next write goes to `end`.
    Result<void> open(int flags, uint64_t end);

    /// Both, one behind the other; after a failure (full disk) the file is as long as before.
    Result<void> append(std::span<const uint8_t> first, std::span<const uint8_t> second);

    Result<void> patch(uint64_t at, std::span<const uint8_t> bytes);
    Result<void> cut(uint64_t end);
    Result<void> sync();
    Result<void> rename_to(const std::filesystem::path& path);

    uint64_t end() const { return end_; }
    const std::filesystem::path& path() const { return path_; }

  private:
    bool write_at_end(std::span<const uint8_t> bytes);
    tl::unexpected<Failure> refuse(const char* what) const;

    std::filesystem::path path_;
    int descriptor_ = -1;
    uint64_t end_ = 0;
};

}  // namespace deixis
