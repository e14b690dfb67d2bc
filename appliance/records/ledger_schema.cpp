// Each version is a step of SQL that is never edited once released; a new need is a new step at the end.
#include "appliance/records/ledger_schema.h"

#include <SQLiteCpp/SQLiteCpp.h>

#include <array>

#include "appliance/records/ledger_failure.h"

namespace deixis {
namespace {

constexpr std::array<const char*, DefectLedger::schema_version> steps{
    // 1: parts and their defects
    R"(
    CREATE TABLE schema_version (version INTEGER PRIMARY KEY, applied_us INTEGER NOT NULL);
    CREATE TABLE part (
      id INTEGER PRIMARY KEY,
      type TEXT NOT NULL,
      serial TEXT NOT NULL,
      UNIQUE (type, serial));
    CREATE TABLE defect (
      id INTEGER PRIMARY KEY AUTOINCREMENT,
      part INTEGER NOT NULL REFERENCES part (id),
      x_m REAL NOT NULL, y_m REAL NOT NULL, z_m REAL NOT NULL,
      normal_x REAL NOT NULL, normal_y REAL NOT NULL, normal_z REAL NOT NULL,
      zone TEXT NOT NULL,
      time_us INTEGER NOT NULL,
      session_us INTEGER NOT NULL,
      arm TEXT NOT NULL CHECK (arm IN ('left', 'right')),
      confidence REAL NOT NULL CHECK (confidence BETWEEN 0 AND 1),
      state TEXT NOT NULL CHECK (state IN ('open', 'confirmed', 'withdrawn')),
      source TEXT NOT NULL);
    CREATE INDEX defect_by_part ON defect (part);
    CREATE INDEX defect_by_time ON defect (time_us);
    )",
    // 2: touch, the PLC's echo, and who changed a state when
    R"(
    ALTER TABLE defect ADD COLUMN touch INTEGER NOT NULL DEFAULT 0 CHECK (touch IN (0, 1));
    ALTER TABLE defect ADD COLUMN delivered_us INTEGER;
    CREATE INDEX defect_undelivered ON defect (id) WHERE delivered_us IS NULL;
    CREATE TABLE state_change (
      id INTEGER PRIMARY KEY AUTOINCREMENT,
      defect INTEGER NOT NULL REFERENCES defect (id),
      state TEXT NOT NULL CHECK (state IN ('open', 'confirmed', 'withdrawn')),
      who TEXT NOT NULL,
      time_us INTEGER NOT NULL);
    CREATE INDEX state_change_by_defect ON state_change (defect);
    INSERT INTO state_change (defect, state, who, time_us) SELECT id, state, 'station', time_us FROM defect;
    UPDATE defect SET delivered_us = time_us;  -- the PLC of that time was told without an echo
    )"};

}  // namespace

int ledger_version(SQLite::Database& database) {
    if (!database.tableExists("schema_version")) return 0;
    return database.execAndGet("SELECT coalesce(max(version), 0) FROM schema_version").getInt();
}

LedgerResult<void> check_ledger_identity(SQLite::Database& database, const std::filesystem::path& file) {
    const int application = database.execAndGet("PRAGMA application_id").getInt();
    const int tables = database.execAndGet("SELECT count(*) FROM sqlite_master").getInt();
    if (application != ledger_application_id && (application != 0 || tables != 0))
        return ledger_fail(LedgerTrouble::not_a_ledger,
                           "the file " + file.string() +
                               " is not a Deixis record: it is an SQLite database "
                               "of another program; it is left as it is");
    const int version = ledger_version(database);
    if (version > DefectLedger::schema_version)
        return ledger_fail(LedgerTrouble::newer,
                           "the record " + file.string() + " was written by a newer Deixis (version " +
                               std::to_string(version) + " of its tables, this program knows up to " +
                               std::to_string(DefectLedger::schema_version) +
                               "); it is left as it is: update this program");
    return {};
}

void migrate_ledger(SQLite::Database& database, int64_t now_us) {
    if (ledger_version(database) == DefectLedger::schema_version) return;
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    // Read again under the write lock: another process may have been first.
    for (int version = ledger_version(database) + 1; version <= DefectLedger::schema_version; ++version) {
        database.exec(steps[version - 1]);
        SQLite::Statement note(database, "INSERT INTO schema_version (version, applied_us) VALUES (?, ?)");
        note.bind(1, version);
        note.bind(2, now_us);
        note.exec();
    }
    transaction.commit();
}

}  // namespace deixis
