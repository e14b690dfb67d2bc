// A disk that fails when told to: an SQLite file system layer over the real one, the default while it lives.
#pragma once

namespace deixis {

enum class DiskFault { none, full, write_error, sync_error };

/// Files opened while an object of this class lives fail as set. One at a time; it outlives their
/// connections.
class FailingDisk {
  public:
    FailingDisk();
    ~FailingDisk();
    void set(DiskFault fault);
    FailingDisk(const FailingDisk&) = delete;
    FailingDisk& operator=(const FailingDisk&) = delete;
};

}  // namespace deixis
