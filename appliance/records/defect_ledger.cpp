// The ledger's statements: one transaction a change, one select a question.
#include "appliance/records/defect_ledger.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <sys/stat.h>

#include <cmath>
#include <mutex>

#include "appliance/records/ledger_failure.h"
#include "appliance/records/ledger_file.h"
#include "appliance/records/utc_time.h"

namespace deixis {
namespace {

constexpr size_t longest_text = 4096;

/// What is wrong with the record; empty when nothing is.
std::string complaint_about(const DefectRecord& record) {
    const PartSpot& spot = record.mark.spot;
    if (!spot.position.allFinite()) return "its position is not finite";
    if (!spot.normal.allFinite()) return "its normal is not finite";
    if (!(record.mark.confidence >= 0 && record.mark.confidence <= 1)) return "its confidence is not 0 to 1";
    if (record.time_us < earliest_utc_us || record.time_us > latest_utc_us)
        return "its time is not in the years 1 to 9999";
    if (record.source.empty()) return "its source is empty";
    for (const std::string* text : {&record.part_type, &record.part_serial, &record.zone, &record.source})
        if (text->size() > longest_text) return "a text of it has more than 4096 bytes";
    return {};
}

/// The conditions of a filter as SQL, and the same conditions' values.
std::string where(const DefectFilter& filter) {
    std::string sql = " WHERE defect.id > :after";
    if (filter.since_us) sql += " AND defect.time_us >= :since";
    if (filter.until_us) sql += " AND defect.time_us < :until";
    if (filter.part_type) sql += " AND part.type = :type";
    if (filter.part_serial) sql += " AND part.serial = :serial";
    if (filter.source) sql += " AND defect.source = :source";
    if (filter.state) sql += " AND defect.state = :state";
    if (filter.undelivered) sql += " AND defect.delivered_us IS NULL";
    return sql;
}

void bind(SQLite::Statement& statement, const DefectFilter& filter) {
    statement.bind(":after", filter.after);
    if (filter.since_us) statement.bind(":since", *filter.since_us);
    if (filter.until_us) statement.bind(":until", *filter.until_us);
    if (filter.part_type) statement.bind(":type", *filter.part_type);
    if (filter.part_serial) statement.bind(":serial", *filter.part_serial);
    if (filter.source) statement.bind(":source", *filter.source);
    if (filter.state) statement.bind(":state", name_of(*filter.state));
}

constexpr const char* select_defects =
    "SELECT defect.id, part.type, part.serial, x_m, y_m, z_m, normal_x, normal_y, normal_z, zone, time_us, "
    "session_us, arm, confidence, touch, state, source, delivered_us "
    "FROM defect JOIN part ON part.id = defect.part";

DefectRecord record_of(SQLite::Statement& row) {
    DefectRecord record;
    record.id = row.getColumn(0).getInt64();
    record.part_type = row.getColumn(1).getString();
    record.part_serial = row.getColumn(2).getString();
    for (int axis = 0; axis < 3; ++axis) {
        record.mark.spot.position[axis] = row.getColumn(3 + axis).getDouble();
        record.mark.spot.normal[axis] = row.getColumn(6 + axis).getDouble();
    }
    record.zone = row.getColumn(9).getString();
    record.time_us = row.getColumn(10).getInt64();
    record.mark.timestamp_us = row.getColumn(11).getInt64();
    record.mark.arm = row.getColumn(12).getString() == "left" ? ArmSide::left : ArmSide::right;
    record.mark.confidence = row.getColumn(13).getDouble();
    record.mark.touch = row.getColumn(14).getInt() != 0;
    record.state = defect_state_of(row.getColumn(15).getString()).value_or(DefectState::open);
    record.source = row.getColumn(16).getString();
    if (!row.getColumn(17).isNull()) record.delivered_us = row.getColumn(17).getInt64();
    return record;
}

}  // namespace

/// The open file, its lock, and the identity by which a file deleted under us is noticed.
class DefectLedger::Connection {
  public:
    Connection(std::unique_ptr<SQLite::Database> database, std::filesystem::path path)
        : database_(std::move(database)), path_(std::move(path)) {
        struct stat status {};
        if (::stat(path_.c_str(), &status) == 0) {
            device_ = status.st_dev;
            inode_ = status.st_ino;
        }
    }

    /// Runs `work(database)` under the lock; SQLite's exceptions become failures that say "cannot `doing`".
    template <class T, class Work>
    LedgerResult<T> run(const std::string& doing, Work work) {
        const std::lock_guard lock(mutex_);
        try {
            return work(*database_);
        } catch (const SQLite::Exception& complaint) {
            return tl::unexpected(explain(complaint, doing, path_));
        }
    }

    /// SQLite goes on writing into a deleted file without complaint; every mark in it would be lost.
    LedgerResult<void> still_in_place() const {
        struct stat status {};
        if (::stat(path_.c_str(), &status) == 0 && status.st_dev == device_ && status.st_ino == inode_)
            return {};
        return ledger_fail(LedgerTrouble::unreachable,
                           "cannot write to the record " + path_.string() +
                               ": the file was moved or deleted while it was open; put it back, or start the "
                               "station again to begin a new one");
    }

    const std::filesystem::path& path() const { return path_; }

  private:
    std::mutex mutex_;
    std::unique_ptr<SQLite::Database> database_;
    std::filesystem::path path_;
    dev_t device_ = 0;
    ino_t inode_ = 0;
};

namespace {

int64_t part_id(SQLite::Database& database, const DefectRecord& record) {
    SQLite::Statement insert(database,
                             "INSERT INTO part (type, serial) VALUES (?, ?) ON CONFLICT DO NOTHING");
    insert.bind(1, record.part_type);
    insert.bind(2, record.part_serial);
    insert.exec();
    SQLite::Statement select(database, "SELECT id FROM part WHERE type = ? AND serial = ?");
    select.bind(1, record.part_type);
    select.bind(2, record.part_serial);
    select.executeStep();
    return select.getColumn(0).getInt64();
}

DefectId insert_defect(SQLite::Database& database, const DefectRecord& record, int64_t part) {
    SQLite::Statement insert(
        database,
        "INSERT INTO defect (part, x_m, y_m, z_m, normal_x, normal_y, normal_z, zone, time_us, session_us, "
        "arm, "
        "confidence, touch, state, source) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    insert.bind(1, part);
    for (int axis = 0; axis < 3; ++axis) {
        insert.bind(2 + axis, record.mark.spot.position[axis]);
        insert.bind(5 + axis, record.mark.spot.normal[axis]);
    }
    insert.bind(8, record.zone);
    insert.bind(9, record.time_us);
    insert.bind(10, record.mark.timestamp_us);
    insert.bind(11, record.mark.arm == ArmSide::left ? "left" : "right");
    insert.bind(12, record.mark.confidence);
    insert.bind(13, record.mark.touch ? 1 : 0);
    insert.bind(14, name_of(record.state));
    insert.bind(15, record.source);
    insert.exec();
    return database.getLastInsertRowid();
}

void insert_state_change(SQLite::Database& database, const StateChange& change) {
    SQLite::Statement insert(database,
                             "INSERT INTO state_change (defect, state, who, time_us) VALUES (?, ?, ?, ?)");
    insert.bind(1, change.defect);
    insert.bind(2, name_of(change.state));
    insert.bind(3, change.who);
    insert.bind(4, change.time_us);
    insert.exec();
}

}  // namespace

InvalidSettings LedgerParams::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "busy_timeout_ms", busy_timeout_ms, 0, 60'000);
    return complaints;
}

DefectLedger::DefectLedger(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}
DefectLedger::DefectLedger(DefectLedger&&) noexcept = default;
DefectLedger& DefectLedger::operator=(DefectLedger&&) noexcept = default;
DefectLedger::~DefectLedger() = default;

LedgerResult<DefectLedger> DefectLedger::open(const std::filesystem::path& path, const LedgerParams& params) {
    auto database = open_ledger_file(path, params);
    if (!database) return tl::unexpected(database.error());
    return DefectLedger(std::make_unique<Connection>(std::move(*database), path));
}

LedgerResult<DefectLedger> DefectLedger::open_to_read(const std::filesystem::path& path,
                                                      const LedgerParams& params) {
    auto database = open_ledger_file_to_read(path, params);
    if (!database) return tl::unexpected(database.error());
    return DefectLedger(std::make_unique<Connection>(std::move(*database), path));
}

LedgerResult<LedgerFacts> DefectLedger::inspect(const std::filesystem::path& path,
                                                const LedgerParams& params) {
    auto look = inspect_ledger_file(path, params);
    if (!look) return tl::unexpected(look.error());
    auto ledger = open_to_read(path, {params.busy_timeout_ms, false});
    if (!ledger) return tl::unexpected(ledger.error());
    const auto defects = ledger->count();
    if (!defects) return tl::unexpected(defects.error());
    look->defects = *defects;
    return look;
}

LedgerResult<DefectId> DefectLedger::commit(const DefectRecord& record) {
    if (const std::string complaint = complaint_about(record); !complaint.empty())
        return ledger_fail(LedgerTrouble::refused, "the mark is not recorded: " + complaint);
    return connection_->run<DefectId>(
        "write a mark to", [&](SQLite::Database& database) -> LedgerResult<DefectId> {
            if (auto place = connection_->still_in_place(); !place) return tl::unexpected(place.error());
            SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
            const DefectId id = insert_defect(database, record, part_id(database, record));
            insert_state_change(database, {id, record.state, "station", record.time_us});
            transaction.commit();  // returns after the write-ahead log is synced
            return id;
        });
}

LedgerResult<std::vector<DefectRecord>> DefectLedger::list(const DefectFilter& filter) const {
    using Records = std::vector<DefectRecord>;
    return connection_->run<Records>("read", [&](SQLite::Database& database) {
        SQLite::Statement select(database,
                                 select_defects + where(filter) + " ORDER BY defect.id LIMIT :limit");
        bind(select, filter);
        select.bind(":limit", filter.limit);
        Records records;
        while (select.executeStep()) records.push_back(record_of(select));
        return records;
    });
}

LedgerResult<int64_t> DefectLedger::count(const DefectFilter& filter) const {
    return connection_->run<int64_t>("read", [&](SQLite::Database& database) {
        SQLite::Statement select(
            database, "SELECT count(*) FROM defect JOIN part ON part.id = defect.part" + where(filter));
        bind(select, filter);
        select.executeStep();
        const int64_t all = select.getColumn(0).getInt64();
        return filter.limit >= 0 ? std::min(all, filter.limit) : all;
    });
}

LedgerResult<void> DefectLedger::set_state(DefectId id, DefectState state, const std::string& who,
                                           int64_t time_us) {
    if (who.empty() || who.size() > longest_text)
        return ledger_fail(LedgerTrouble::refused, "the state of defect " + std::to_string(id) +
                                                       " is not changed: who did it must be told");
    return connection_->run<void>("write a state to", [&](SQLite::Database& database) -> LedgerResult<void> {
        if (auto place = connection_->still_in_place(); !place) return place;
        SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
        SQLite::Statement select(database, "SELECT state FROM defect WHERE id = ?");
        select.bind(1, id);
        if (!select.executeStep())
            return ledger_fail(LedgerTrouble::refused, "there is no defect " + std::to_string(id));
        if (select.getColumn(0).getString() == name_of(state)) return {};
        select.reset();
        SQLite::Statement update(database, "UPDATE defect SET state = ? WHERE id = ?");
        update.bind(1, name_of(state));
        update.bind(2, id);
        update.exec();
        insert_state_change(database, {id, state, who, time_us});
        transaction.commit();
        return {};
    });
}

LedgerResult<std::vector<StateChange>> DefectLedger::history(DefectId id) const {
    using Changes = std::vector<StateChange>;
    return connection_->run<Changes>("read", [&](SQLite::Database& database) {
        SQLite::Statement select(database,
                                 "SELECT state, who, time_us FROM state_change WHERE defect = ? ORDER BY id");
        select.bind(1, id);
        Changes changes;
        while (select.executeStep())
            changes.push_back({id,
                               defect_state_of(select.getColumn(0).getString()).value_or(DefectState::open),
                               select.getColumn(1).getString(), select.getColumn(2).getInt64()});
        return changes;
    });
}

LedgerResult<void> DefectLedger::set_delivered(DefectId id, int64_t time_us) {
    return connection_->run<void>("write to", [&](SQLite::Database& database) -> LedgerResult<void> {
        if (auto place = connection_->still_in_place(); !place) return place;
        SQLite::Statement update(database,
                                 "UPDATE defect SET delivered_us = coalesce(delivered_us, ?) WHERE id = ?");
        update.bind(1, time_us);
        update.bind(2, id);
        if (update.exec() == 0)
            return ledger_fail(LedgerTrouble::refused, "there is no defect " + std::to_string(id));
        return {};
    });
}

LedgerResult<std::vector<std::string>> DefectLedger::integrity_complaints() const {
    return connection_->run<std::vector<std::string>>(
        "read", [](SQLite::Database& database) { return check_lines(database, false); });
}

std::string DefectLedger::library_version() {
    return std::string("SQLite ") + SQLite::getLibVersion();
}

const std::filesystem::path& DefectLedger::path() const {
    return connection_->path();
}

}  // namespace deixis
