// One sentence a cause: what happened to which file, and what to do.
#include "appliance/records/ledger_failure.h"

#include <SQLiteCpp/Exception.h>
#include <sqlite3.h>

namespace deixis {

LedgerFailure damaged_ledger(const std::filesystem::path& file, const std::string& detail) {
    return {
        {"the record " + file.string() + " is damaged (" + detail +
         "); it is left as it is: move it aside with its -wal and -shm files to begin a new one, and keep "
         "it for repair"},
        LedgerTrouble::damaged};
}

LedgerFailure explain(const SQLite::Exception& complaint, const std::string& doing,
                      const std::filesystem::path& file) {
    const std::string cannot = "cannot " + doing + " the record " + file.string() + ": ";
    switch (complaint.getErrorCode()) {
        case SQLITE_FULL:
            return {{cannot + "the disk is full; free some space, waiting marks are tried again"},
                    LedgerTrouble::disk_full};
        case SQLITE_BUSY:
        case SQLITE_LOCKED:
            return {{cannot + "another program has locked it; close that program or wait"},
                    LedgerTrouble::locked};
        case SQLITE_READONLY:
        case SQLITE_PERM:
            return {{cannot + "the file or its folder may not be written; give this user the right to write"},
                    LedgerTrouble::read_only};
        case SQLITE_CORRUPT:
            return damaged_ledger(file, complaint.getErrorStr());
        case SQLITE_NOTADB:
            return {{"the file " + file.string() +
                     " is not a Deixis record: it is no SQLite database; it is left as it is"},
                    LedgerTrouble::not_a_ledger};
        default:
            return {{cannot + complaint.what() + " (SQLite code " +
                     std::to_string(complaint.getExtendedErrorCode()) + "); check the disk and its cable"},
                    LedgerTrouble::unreachable};
    }
}

}  // namespace deixis
