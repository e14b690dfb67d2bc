// Opening the ledger's file: what must be true before SQLite may touch it, and how SQLite is told to treat
// it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "appliance/records/defect_ledger.h"

namespace SQLite {
class Database;
}

namespace deixis {

/// A connection to the file, made when missing, in WAL mode, synchronous=FULL, tables of the newest version.
LedgerResult<std::unique_ptr<SQLite::Database>> open_ledger_file(const std::filesystem::path& file,
                                                                 const LedgerParams& params);

/// A connection that cannot write; a copy in memory when the tables are of an older version.
LedgerResult<std::unique_ptr<SQLite::Database>> open_ledger_file_to_read(const std::filesystem::path& file,
                                                                         const LedgerParams& params);

/// All of LedgerFacts but the number of defects.
LedgerResult<LedgerFacts> inspect_ledger_file(const std::filesystem::path& file, const LedgerParams& params);

/// Lines of SQLite's check, without its "ok". `quick` skips the indices. Throws SQLite::Exception.
std::vector<std::string> check_lines(SQLite::Database& database, bool quick);

}  // namespace deixis
