// The tables of the ledger, version by version, and the way from an older version to the newest.
#pragma once

#include <filesystem>

#include "appliance/records/defect_ledger.h"

namespace SQLite {
class Database;
}

namespace deixis {

/// Written into the SQLite header: "DXLG".
inline constexpr int ledger_application_id = 0x44584C47;

/// Version of the tables in `database`; 0 = none yet. Throws SQLite::Exception.
int ledger_version(SQLite::Database& database);

/// Refuses a database that is another program's or a newer Deixis's, without writing to it.
/// Throws SQLite::Exception.
LedgerResult<void> check_ledger_identity(SQLite::Database& database, const std::filesystem::path& file);

/// Brings the tables to DefectLedger::schema_version in one transaction; does nothing when they are there.
/// Throws SQLite::Exception, and then nothing has changed.
void migrate_ledger(SQLite::Database& database, int64_t now_us);

}  // namespace deixis
