// The order matters: look at the file's first bytes, at its owner and version, at every page; only then
// write.
#include "appliance/records/ledger_file.h"

#include <SQLiteCpp/Backup.h>
#include <SQLiteCpp/SQLiteCpp.h>
#include <sqlite3.h>

#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "appliance/records/ledger_failure.h"
#include "appliance/records/ledger_schema.h"
#include "appliance/records/utc_time.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;
using DatabasePointer = std::unique_ptr<SQLite::Database>;

uintmax_t size_or_zero(const fs::path& file) {
    std::error_code trouble;
    const uintmax_t size = fs::file_size(file, trouble);
    return trouble ? 0 : size;
}

fs::path wal_of(const fs::path& file) {
    return file.string() + "-wal";
}

/// SQLite takes an empty file for a new database and deletes its write-ahead log, which may hold every mark.
LedgerResult<void> check_first_bytes(const fs::path& file) {
    std::error_code trouble;
    if (fs::is_directory(file, trouble))
        return ledger_fail(LedgerTrouble::not_a_ledger,
                           "the record " + file.string() + " is a folder; expected a file");
    if (!fs::exists(file, trouble)) {
        const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
        if (!fs::is_directory(folder, trouble))
            return ledger_fail(LedgerTrouble::unreachable, "cannot open the record " + file.string() +
                                                               ": the folder " + folder.string() +
                                                               " does not exist; make it first");
    }
    if (fs::exists(file, trouble) && !fs::is_regular_file(file, trouble))
        return ledger_fail(LedgerTrouble::not_a_ledger,
                           "the record " + file.string() + " is no regular file; expected a file");
    const uintmax_t size = size_or_zero(file);
    if (size == 0) {
        if (size_or_zero(wal_of(file)) > 0)
            return tl::unexpected(damaged_ledger(file, "the file is empty but its -wal file is not"));
        return {};
    }
    constexpr std::string_view magic("SQLite format 3\0", 16);
    std::array<char, 16> head{};
    std::ifstream stream(file, std::ios::binary);
    stream.read(head.data(), head.size());
    if (!stream && stream.gcount() == 0)
        return ledger_fail(LedgerTrouble::read_only,
                           "cannot open the record " + file.string() +
                               ": it may not be read; give this user the right to read");
    const auto read = static_cast<size_t>(stream.gcount());
    if (std::string_view(head.data(), read) != magic)
        return ledger_fail(LedgerTrouble::not_a_ledger,
                           "the file " + file.string() +
                               " is not a Deixis record: it does not begin as an SQLite database does; it is "
                               "left as it is");
    if (size < 512)
        return tl::unexpected(damaged_ledger(file, "only " + std::to_string(size) + " bytes long"));
    return {};
}

LedgerResult<void> check_exists(const fs::path& file) {
    std::error_code trouble;
    if (!fs::exists(file, trouble))
        return ledger_fail(LedgerTrouble::unreachable, "there is no record at " + file.string());
    return check_first_bytes(file);
}

LedgerResult<void> check_content(SQLite::Database& database, const fs::path& file,
                                 const LedgerParams& params) {
    if (auto identity = check_ledger_identity(database, file); !identity) return identity;
    if (!params.check_on_open) return {};
    const std::vector<std::string> complaints = check_lines(database, true);
    if (complaints.empty()) return {};
    return tl::unexpected(damaged_ledger(file, complaints.front()));
}

/// Settings that SQLite may silently not honour are read back.
LedgerResult<void> make_durable(SQLite::Database& database, const fs::path& file) {
    if (sqlite3_db_readonly(database.getHandle(), "main") != 0)
        return ledger_fail(
            LedgerTrouble::read_only,
            "cannot write to the record " + file.string() +
                ": the file or its folder may not be written; give this user the right to write");
    if (database.execAndGet("PRAGMA application_id").getInt() == 0)
        database.exec("PRAGMA application_id = " + std::to_string(ledger_application_id));
    const std::string mode = database.execAndGet("PRAGMA journal_mode = WAL").getString();
    if (mode != "wal")
        return ledger_fail(
            LedgerTrouble::unreachable,
            "cannot open the record " + file.string() +
                ": its file system has no shared memory for a write-ahead log (journal mode \"" + mode +
                "\"); use a local disk");
    database.exec("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON; PRAGMA cell_size_check = ON");
    database.exec("PRAGMA journal_size_limit = 8388608");
    return {};
}

/// A read-only folder cannot hold the shared memory of a write-ahead log; without log there is nothing to
/// share.
DatabasePointer open_read_only(const fs::path& file, const LedgerParams& params) {
    try {
        auto database =
            std::make_unique<SQLite::Database>(file.string(), SQLite::OPEN_READONLY, params.busy_timeout_ms);
        database->execAndGet("SELECT count(*) FROM sqlite_master");
        return database;
    } catch (const SQLite::Exception& complaint) {
        const int code = complaint.getErrorCode();
        if ((code != SQLITE_CANTOPEN && code != SQLITE_READONLY) || size_or_zero(wal_of(file)) > 0) throw;
    }
    std::string escaped;
    for (const char c : fs::absolute(file).string()) {
        constexpr std::string_view digits = "0123456789ABCDEF";
        const auto byte = static_cast<unsigned char>(c);
        if (c == '%' || c == '?' || c == '#')
            escaped += {'%', digits[byte >> 4], digits[byte & 15]};
        else
            escaped += c;
    }
    return std::make_unique<SQLite::Database>(
        "file:" + escaped + "?immutable=1", SQLite::OPEN_READONLY | SQLite::OPEN_URI, params.busy_timeout_ms);
}

DatabasePointer newest_copy_in_memory(SQLite::Database& older) {
    auto copy = std::make_unique<SQLite::Database>(":memory:", SQLite::OPEN_READWRITE);
    SQLite::Backup backup(*copy, older);
    backup.executeStep();
    migrate_ledger(*copy, utc_now_us());
    return copy;
}

}  // namespace

std::vector<std::string> check_lines(SQLite::Database& database, bool quick) {
    SQLite::Statement check(database, quick ? "PRAGMA quick_check(5)" : "PRAGMA integrity_check(100)");
    std::vector<std::string> lines;
    while (check.executeStep()) lines.push_back(check.getColumn(0).getString());
    if (lines.size() == 1 && lines.front() == "ok") lines.clear();
    return lines;
}

LedgerResult<DatabasePointer> open_ledger_file(const fs::path& file, const LedgerParams& params) {
    if (auto bytes = check_first_bytes(file); !bytes) return tl::unexpected(bytes.error());
    try {
        auto database = std::make_unique<SQLite::Database>(
            file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, params.busy_timeout_ms);
        if (auto content = check_content(*database, file, params); !content)
            return tl::unexpected(content.error());
        if (auto durable = make_durable(*database, file); !durable) return tl::unexpected(durable.error());
        migrate_ledger(*database, utc_now_us());
        return database;
    } catch (const SQLite::Exception& complaint) {
        return tl::unexpected(explain(complaint, "open", file));
    }
}

LedgerResult<DatabasePointer> open_ledger_file_to_read(const fs::path& file, const LedgerParams& params) {
    if (auto exists = check_exists(file); !exists) return tl::unexpected(exists.error());
    try {
        DatabasePointer database = open_read_only(file, params);
        if (auto content = check_content(*database, file, params); !content)
            return tl::unexpected(content.error());
        if (ledger_version(*database) < DefectLedger::schema_version) return newest_copy_in_memory(*database);
        return database;
    } catch (const SQLite::Exception& complaint) {
        return tl::unexpected(explain(complaint, "open", file));
    }
}

LedgerResult<LedgerFacts> inspect_ledger_file(const fs::path& file, const LedgerParams& params) {
    if (auto exists = check_exists(file); !exists) return tl::unexpected(exists.error());
    try {
        const DatabasePointer database = open_read_only(file, params);
        if (auto identity = check_ledger_identity(*database, file); !identity)
            return tl::unexpected(identity.error());
        LedgerFacts facts;
        facts.tables_version = ledger_version(*database);
        facts.write_ahead_log = database->execAndGet("PRAGMA journal_mode").getString() == "wal";
        facts.complaints = check_lines(*database, false);
        return facts;
    } catch (const SQLite::Exception& complaint) {
        return tl::unexpected(explain(complaint, "read", file));
    }
}

}  // namespace deixis
