// Files the ledger finds: older, newer, foreign, damaged, empty; none of the refused ones may change by a
// byte.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <random>
#include <regex>

#include "tests/appliance/records/ledger_fixture.h"

namespace deixis {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class LedgerFileTest : public LedgerFolder {
  protected:
    void write_version_1() const {
        SQLite::Database database(file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
        database.exec(bytes_of(LEDGER_VERSION_1));
    }

    /// A ledger with `marks` marks whose write-ahead log has been folded into the file.
    std::string write_ledger(int marks) const {
        {
            auto ledger = DefectLedger::open(file_);
            EXPECT_TRUE(ledger) << ledger.error().sentence;
            DefectRecord record = sample_record();
            record.zone = std::string(1'500, 'z');  // so that few commits fill many pages
            for (int n = 1; n <= marks; ++n) EXPECT_TRUE(ledger->commit(record));
        }
        return bytes_of(file_);
    }

    void expect_refused(const std::string& content, LedgerTrouble trouble,
                        const std::string& part_of_sentence) const {
        write_bytes(file_, content);
        for (const bool write : {true, false}) {
            const auto ledger = write ? DefectLedger::open(file_) : DefectLedger::open_to_read(file_);
            ASSERT_FALSE(ledger) << part_of_sentence;
            EXPECT_EQ(ledger.error().trouble, trouble) << ledger.error().sentence;
            EXPECT_THAT(ledger.error().sentence,
                        AllOf(HasSubstr(file_.string()), HasSubstr(part_of_sentence)));
            EXPECT_EQ(bytes_of(file_), content) << "must be left as it is";
        }
    }
};

TEST_F(LedgerFileTest, BringsVersion1UpToDateAndKeepsWhatItHolds) {
    write_version_1();
    auto ledger = DefectLedger::open(file_);
    ASSERT_TRUE(ledger) << ledger.error().sentence;
    const auto records = ledger->list().value();
    ASSERT_EQ(records.size(), 3U);
    EXPECT_EQ(records[0].mark.spot.position, Eigen::Vector3d(0.25, 0.5, 0.125));
    EXPECT_EQ(records[1].state, DefectState::confirmed);
    EXPECT_EQ(records[2].id, 5);
    EXPECT_EQ(records[2].part_serial, "0002");
    EXPECT_FALSE(records[2].mark.touch);
    EXPECT_EQ(records[0].delivered_us, 1700000001000000) << "old defects are not sent to the PLC again";
    EXPECT_EQ(ledger->history(2).value().at(0).state, DefectState::confirmed);
    DefectRecord touched = sample_record(3);
    EXPECT_EQ(ledger->commit(touched).value(), 6);
    EXPECT_TRUE(ledger->list().value()[3].mark.touch);
    EXPECT_EQ(DefectLedger::inspect(file_).value().tables_version, 2);
    EXPECT_TRUE(ledger->integrity_complaints().value().empty());
}

TEST_F(LedgerFileTest, MigratedTablesAreThoseOfANewFile) {
    write_version_1();
    const auto tables = [](const std::filesystem::path& file) {
        SQLite::Database database(file.string());
        SQLite::Statement select(database,
                                 "SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY name");
        std::string all;
        while (select.executeStep()) all += select.getColumn(0).getString() + ";";
        return std::regex_replace(all, std::regex("\\s+"), " ");
    };
    ASSERT_TRUE(DefectLedger::open(file_));
    ASSERT_TRUE(DefectLedger::open(folder_ / "new.db"));
    EXPECT_EQ(tables(file_), tables(folder_ / "new.db"));
}

TEST_F(LedgerFileTest, ReadsVersion1WithoutChangingIt) {
    write_version_1();
    const std::string before = bytes_of(file_);
    {
        auto ledger = DefectLedger::open_to_read(file_);
        ASSERT_TRUE(ledger) << ledger.error().sentence;
        EXPECT_EQ(ledger->list().value().size(), 3U);
        EXPECT_EQ(ledger->history(5).value().size(), 1U);
    }
    EXPECT_EQ(bytes_of(file_), before);
    EXPECT_EQ(DefectLedger::inspect(file_).value().tables_version, 1);
}

TEST_F(LedgerFileTest, AFailedMigrationChangesNothing) {
    write_version_1();
    {
        SQLite::Database database(file_.string(), SQLite::OPEN_READWRITE);
        database.exec("CREATE TABLE state_change (somebody_elses INTEGER)");
    }
    const auto ledger = DefectLedger::open(file_);
    ASSERT_FALSE(ledger);
    EXPECT_THAT(ledger.error().sentence,
                AllOf(HasSubstr(file_.string()), HasSubstr("state_change already exists")));
    SQLite::Database database(file_.string());
    EXPECT_EQ(database.execAndGet("SELECT max(version) FROM schema_version").getInt(), 1);
    EXPECT_EQ(
        database.execAndGet("SELECT count(*) FROM pragma_table_info('defect') WHERE name = 'touch'").getInt(),
        0);
}

TEST_F(LedgerFileTest, RefusesANewerRecordByName) {
    write_ledger(1);
    {
        SQLite::Database database(file_.string(), SQLite::OPEN_READWRITE);
        database.exec("INSERT INTO schema_version VALUES (3, 0)");
    }
    expect_refused(bytes_of(file_), LedgerTrouble::newer,
                   "was written by a newer Deixis (version 3 of its tables, this program knows up to 2)");
}

TEST_F(LedgerFileTest, RefusesFilesThatAreNoLedger) {
    std::mt19937 random(3);
    std::string noise(5000, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    const std::string not_sqlite = "it does not begin as an SQLite database does";
    for (const std::string& content :
         {std::string("x"), std::string("SQLite"), std::string("SQLite format 4\0", 16),
          std::string(100, '\0'), std::string(1 << 20, '\xff'), std::string("id,time\r\n1,2\r\n"),
          std::string("{\"a\": 1}"), noise, std::string("SQLite format 3 "), std::string("\n")})
        expect_refused(content, LedgerTrouble::not_a_ledger, not_sqlite);
}

TEST_F(LedgerFileTest, RefusesAnotherProgramsDatabase) {
    {
        SQLite::Database database(file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
        database.exec("CREATE TABLE holidays (day TEXT)");
    }
    expect_refused(bytes_of(file_), LedgerTrouble::not_a_ledger,
                   "it is an SQLite database of another program");
    {
        SQLite::Database database(file_.string(), SQLite::OPEN_READWRITE);
        database.exec("PRAGMA application_id = 42");
    }
    expect_refused(bytes_of(file_), LedgerTrouble::not_a_ledger,
                   "it is an SQLite database of another program");
}

TEST_F(LedgerFileTest, RefusesTruncatedLedgers) {
    const std::string whole = write_ledger(30);
    ASSERT_GT(whole.size(), 40'000U);
    for (const size_t size : {size_t{16}, size_t{99}, size_t{100}, size_t{511}})
        expect_refused(
            whole.substr(0, size), LedgerTrouble::damaged,
            "is damaged (only " + std::to_string(size) + " bytes long); it is left as it is: move it aside");
    for (const size_t pages : {1, 2, 5, 9})
        expect_refused(whole.substr(0, 4096 * pages), LedgerTrouble::damaged, "is damaged (");
}

TEST_F(LedgerFileTest, RefusesOverwrittenPages) {
    const std::string whole = write_ledger(30);
    const size_t pages = whole.size() / 4096;
    for (size_t page = 1; page < pages; ++page) {
        std::string damaged = whole;
        damaged.replace(4096 * page, 4096, std::string(4096, '\xA5'));
        expect_refused(damaged, LedgerTrouble::damaged, "is damaged (");
    }
}

TEST_F(LedgerFileTest, NeverCrashesOnFlippedBytes) {
    const std::string whole = write_ledger(30);
    std::mt19937 random(11);
    int refused = 0;
    for (int trial = 0; trial < 300; ++trial) {
        std::string damaged = whole;
        for (int flips = 1 + trial % 8; flips > 0; --flips)
            damaged[random() % damaged.size()] ^= static_cast<char>(1U << random() % 8);
        write_bytes(file_, damaged);
        const auto ledger = DefectLedger::open_to_read(file_);
        if (!ledger) {
            ++refused;
            EXPECT_THAT(ledger.error().sentence, HasSubstr(file_.string()));
            EXPECT_EQ(bytes_of(file_), damaged);
        } else if (const auto records = ledger->list(); !records) {
            EXPECT_THAT(records.error().sentence, HasSubstr(file_.string()));
        }
    }
    EXPECT_GT(refused, 30);
}

TEST_F(LedgerFileTest, DoesNotThrowAwayTheLogOfAnEmptiedFile) {
    write_bytes(file_, "");
    write_bytes(file_.string() + "-wal", "marks that nobody has folded in yet");
    const auto ledger = DefectLedger::open(file_);
    ASSERT_FALSE(ledger);
    EXPECT_THAT(ledger.error().sentence,
                HasSubstr("is damaged (the file is empty but its -wal file is not)"));
    EXPECT_EQ(bytes_of(file_.string() + "-wal"), "marks that nobody has folded in yet");
}

TEST_F(LedgerFileTest, BeginsANewRecordInAMissingOrEmptyFile) {
    EXPECT_EQ(DefectLedger::open(file_).value().commit(sample_record()).value(), 1);
    write_bytes(folder_ / "empty.db", "");
    EXPECT_EQ(DefectLedger::open(folder_ / "empty.db").value().commit(sample_record()).value(), 1);
}

TEST_F(LedgerFileTest, SaysWhatIsNotThere) {
    EXPECT_EQ(DefectLedger::open_to_read(file_).error().sentence, "there is no record at " + file_.string());
    EXPECT_FALSE(std::filesystem::exists(file_)) << "reading makes no file";
    EXPECT_EQ(DefectLedger::open(folder_ / "no" / "deixis.db").error().sentence,
              "cannot open the record " + (folder_ / "no" / "deixis.db").string() + ": the folder " +
                  (folder_ / "no").string() + " does not exist; make it first");
    EXPECT_EQ(DefectLedger::open(folder_).error().sentence,
              "the record " + folder_.string() + " is a folder; expected a file");
    const auto pipe = folder_ / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_EQ(DefectLedger::open_to_read(pipe).error().sentence,
              "the record " + pipe.string() + " is no regular file; expected a file");
}

}  // namespace
}  // namespace deixis
