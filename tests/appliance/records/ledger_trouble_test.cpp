// Trouble while the ledger is open: disk full, write and sync errors, locks, rights, a file taken away.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

#include "tests/appliance/records/failing_disk.h"
#include "tests/appliance/records/ledger_fixture.h"

namespace deixis {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using LedgerTroubleTest = LedgerFolder;

TEST_F(LedgerTroubleTest, AFullDiskLosesNothingThatWasCommitted) {
    FailingDisk disk;
    auto ledger = DefectLedger::open(file_).value();
    ASSERT_TRUE(ledger.commit(sample_record(1)));
    disk.set(DiskFault::full);
    for (int n = 0; n < 3; ++n) {
        const auto id = ledger.commit(sample_record(2));
        ASSERT_FALSE(id);
        EXPECT_EQ(id.error().trouble, LedgerTrouble::disk_full);
        EXPECT_EQ(id.error().sentence,
                  "cannot write a mark to the record " + file_.string() +
                      ": the disk is full; free some space, waiting marks are tried again");
    }
    EXPECT_EQ(ledger.list().value().size(), 1U);
    EXPECT_EQ(ledger.set_state(1, DefectState::confirmed, "me", 0).error().trouble, LedgerTrouble::disk_full);
    EXPECT_EQ(ledger.list().value()[0].state, DefectState::open);
    disk.set(DiskFault::none);
    EXPECT_EQ(ledger.commit(sample_record(2)).value(), 2) << "no half mark took the id";
    EXPECT_TRUE(ledger.integrity_complaints().value().empty());
}

TEST_F(LedgerTroubleTest, AFullDiskRefusesANewRecord) {
    FailingDisk disk;
    disk.set(DiskFault::full);
    const auto ledger = DefectLedger::open(file_);
    ASSERT_FALSE(ledger);
    EXPECT_THAT(ledger.error().sentence, HasSubstr("the disk is full"));
    disk.set(DiskFault::none);
    EXPECT_TRUE(DefectLedger::open(file_)) << "what the failure left behind must not stand in the way";
}

TEST_F(LedgerTroubleTest, AFailedWriteOrSyncIsNoCommit) {
    FailingDisk disk;
    auto ledger = DefectLedger::open(file_).value();
    for (const DiskFault fault : {DiskFault::write_error, DiskFault::sync_error}) {
        disk.set(fault);
        const auto id = ledger.commit(sample_record());
        ASSERT_FALSE(id);
        EXPECT_EQ(id.error().trouble, LedgerTrouble::unreachable);
        EXPECT_THAT(id.error().sentence, HasSubstr("check the disk and its cable"));
        disk.set(DiskFault::none);
        EXPECT_EQ(ledger.count().value(), 0);
    }
    EXPECT_TRUE(ledger.commit(sample_record()));
    EXPECT_TRUE(ledger.integrity_complaints().value().empty());
}

TEST_F(LedgerTroubleTest, ALockSaysSoAndPasses) {
    auto ledger = DefectLedger::open(file_, {20, true}).value();
    SQLite::Database other(file_.string(), SQLite::OPEN_READWRITE);
    other.exec("BEGIN IMMEDIATE");
    const auto id = ledger.commit(sample_record());
    ASSERT_FALSE(id);
    EXPECT_EQ(id.error().trouble, LedgerTrouble::locked);
    EXPECT_EQ(id.error().sentence, "cannot write a mark to the record " + file_.string() +
                                       ": another program has locked it; close that program or wait");
    EXPECT_TRUE(ledger.list().has_value()) << "readers go on";
    other.exec("COMMIT");
    EXPECT_TRUE(ledger.commit(sample_record()));
}

TEST_F(LedgerTroubleTest, AnExclusiveLockOnOpeningSaysSo) {
    ASSERT_TRUE(DefectLedger::open(file_));
    SQLite::Database other(file_.string(), SQLite::OPEN_READWRITE);
    other.exec("PRAGMA locking_mode = EXCLUSIVE; BEGIN EXCLUSIVE; CREATE TABLE t (x)");
    const auto ledger = DefectLedger::open(file_, {20, true});
    ASSERT_FALSE(ledger);
    EXPECT_EQ(ledger.error().trouble, LedgerTrouble::locked) << ledger.error().sentence;
}

TEST_F(LedgerTroubleTest, AFileTakenAwayIsNoticed) {
    auto ledger = DefectLedger::open(file_).value();
    ASSERT_TRUE(ledger.commit(sample_record(1)));
    std::filesystem::rename(file_, folder_ / "away.db");
    const auto id = ledger.commit(sample_record(2));
    ASSERT_FALSE(id);
    EXPECT_THAT(id.error().sentence, HasSubstr("the file was moved or deleted while it was open"));
    EXPECT_FALSE(ledger.set_state(1, DefectState::confirmed, "me", 0));
    EXPECT_FALSE(ledger.set_delivered(1, 0));
    std::filesystem::rename(folder_ / "away.db", file_);
    EXPECT_TRUE(ledger.commit(sample_record(2)));
}

/// Runs `work` in a child without root's right to write everything, and returns what it says.
std::string as_nobody(const std::function<std::string()>& work) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0)) ::_exit(3);
        const std::string said = work();
        const ssize_t written = ::write(ends[1], said.data(), said.size());
        ::_exit(written == static_cast<ssize_t>(said.size()) ? 0 : 4);
    }
    ::close(ends[1]);
    std::string said;
    char buffer[4096];
    for (ssize_t got = 0; (got = ::read(ends[0], buffer, sizeof buffer)) > 0;) said.append(buffer, got);
    ::close(ends[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
    return said;
}

TEST_F(LedgerTroubleTest, AReadOnlyFileIsRefusedForWritingAndReadAsItIs) {
    ASSERT_TRUE(DefectLedger::open(file_).value().commit(sample_record()));
    namespace fs = std::filesystem;
    fs::permissions(file_, fs::perms::owner_read | fs::perms::others_read);
    fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read |
                                 fs::perms::others_exec);
    const std::string said = as_nobody([&]() -> std::string {
        const auto writing = DefectLedger::open(file_);
        const auto reading = DefectLedger::open_to_read(file_);
        return (writing ? std::string("opened") : writing.error().sentence) + "|" +
               (reading ? std::to_string(reading->count().value()) : reading.error().sentence);
    });
    EXPECT_EQ(said, "cannot open the record " + file_.string() +
                        ": the file or its folder may not be written; give this user the right to write|1");
    fs::permissions(folder_, fs::perms::owner_all);
}

TEST_F(LedgerTroubleTest, AFileThatMayNotBeReadIsRefused) {
    ASSERT_TRUE(DefectLedger::open(file_));
    namespace fs = std::filesystem;
    fs::permissions(file_, fs::perms::none);
    fs::permissions(folder_, fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
    const std::string said = as_nobody([&]() -> std::string {
        const auto reading = DefectLedger::open_to_read(file_);
        return reading ? "opened" : reading.error().sentence;
    });
    EXPECT_EQ(said, "cannot open the record " + file_.string() +
                        ": it may not be read; give this user the right to read");
}

}  // namespace
}  // namespace deixis
