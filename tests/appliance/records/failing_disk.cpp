// Every call goes through to the real file; writes and syncs fail first where that is wanted.
#include "tests/appliance/records/failing_disk.h"

#include <sqlite3.h>

#include <atomic>

namespace deixis {
namespace {

std::atomic<DiskFault> current_fault{DiskFault::none};
sqlite3_vfs* real_disk = nullptr;
sqlite3_vfs failing_disk{};

struct FailingFile {
    sqlite3_file base;
    sqlite3_file* real;
};

sqlite3_file* real_of(sqlite3_file* file) {
    return reinterpret_cast<FailingFile*>(file)->real;
}
const sqlite3_io_methods& methods_of(sqlite3_file* file) {
    return *real_of(file)->pMethods;
}

int write_file(sqlite3_file* f, const void* data, int size, sqlite3_int64 offset) {
    if (current_fault == DiskFault::full) return SQLITE_FULL;
    if (current_fault == DiskFault::write_error) return SQLITE_IOERR_WRITE;
    return methods_of(f).xWrite(real_of(f), data, size, offset);
}
int sync_file(sqlite3_file* f, int flags) {
    return current_fault == DiskFault::sync_error ? SQLITE_IOERR_FSYNC
                                                  : methods_of(f).xSync(real_of(f), flags);
}

const sqlite3_io_methods failing_methods{
    3,
    [](sqlite3_file* f) { return methods_of(f).xClose(real_of(f)); },
    [](sqlite3_file* f, void* d, int n, sqlite3_int64 o) { return methods_of(f).xRead(real_of(f), d, n, o); },
    write_file,
    [](sqlite3_file* f, sqlite3_int64 n) { return methods_of(f).xTruncate(real_of(f), n); },
    sync_file,
    [](sqlite3_file* f, sqlite3_int64* n) { return methods_of(f).xFileSize(real_of(f), n); },
    [](sqlite3_file* f, int l) { return methods_of(f).xLock(real_of(f), l); },
    [](sqlite3_file* f, int l) { return methods_of(f).xUnlock(real_of(f), l); },
    [](sqlite3_file* f, int* r) { return methods_of(f).xCheckReservedLock(real_of(f), r); },
    [](sqlite3_file* f, int op, void* a) { return methods_of(f).xFileControl(real_of(f), op, a); },
    [](sqlite3_file* f) { return methods_of(f).xSectorSize(real_of(f)); },
    [](sqlite3_file* f) { return methods_of(f).xDeviceCharacteristics(real_of(f)); },
    [](sqlite3_file* f, int p, int n, int w, void volatile** m) {
        return methods_of(f).xShmMap(real_of(f), p, n, w, m);
    },
    [](sqlite3_file* f, int o, int n, int l) { return methods_of(f).xShmLock(real_of(f), o, n, l); },
    [](sqlite3_file* f) { methods_of(f).xShmBarrier(real_of(f)); },
    [](sqlite3_file* f, int d) { return methods_of(f).xShmUnmap(real_of(f), d); },
    [](sqlite3_file* f, sqlite3_int64 o, int n, void** p) {
        return methods_of(f).xFetch(real_of(f), o, n, p);
    },
    [](sqlite3_file* f, sqlite3_int64 o, void* p) { return methods_of(f).xUnfetch(real_of(f), o, p); },
};

int open_file(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
    auto* failing = reinterpret_cast<FailingFile*>(file);
    failing->real = reinterpret_cast<sqlite3_file*>(failing + 1);
    const int code = real_disk->xOpen(real_disk, name, failing->real, flags, out_flags);
    failing->base.pMethods = code == SQLITE_OK ? &failing_methods : nullptr;
    return code;
}

}  // namespace

FailingDisk::FailingDisk() {
    real_disk = sqlite3_vfs_find(nullptr);
    failing_disk = *real_disk;
    failing_disk.zName = "failing";
    failing_disk.szOsFile = static_cast<int>(sizeof(FailingFile)) + real_disk->szOsFile;
    failing_disk.xOpen = open_file;
    current_fault = DiskFault::none;
    sqlite3_vfs_register(&failing_disk, 1);
}

FailingDisk::~FailingDisk() {
    sqlite3_vfs_unregister(&failing_disk);
    sqlite3_vfs_register(real_disk, 1);
}

void FailingDisk::set(DiskFault fault) {
    current_fault = fault;
}

}  // namespace deixis
