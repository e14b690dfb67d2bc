// Queue and writer: the order is kept, nothing waits for the disk, nothing is lost or dropped without a word.
#include "appliance/records/mark_recorder.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <chrono>
#include <functional>
#include <thread>

#include "tests/appliance/records/failing_disk.h"
#include "tests/appliance/records/ledger_fixture.h"

namespace deixis {
namespace {

using ::testing::HasSubstr;

class MarkRecorderTest : public LedgerFolder {
  protected:
    static void wait_until(const std::function<bool()>& done) {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (!done() && std::chrono::steady_clock::now() < deadline)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));  // its thread has no other sign
        ASSERT_TRUE(done());
    }

    static std::unique_ptr<MarkRecorder> start(DefectLedger& ledger, int queue_length = 64) {
        MarkRecorderParams params;
        params.queue_length = queue_length;
        params.retry_first_ms = 1;
        params.retry_longest_ms = 4;
        return MarkRecorder::start(ledger, params).value();
    }
};

TEST_F(MarkRecorderTest, CommitsInOrderAndHandsOutIds) {
    auto ledger = DefectLedger::open(file_).value();
    const auto recorder = start(ledger);
    std::vector<DefectRecord> committed;
    for (int n = 1; n <= 20; ++n) ASSERT_TRUE(recorder->post(sample_record(n)));
    wait_until([&] {
        for (DefectRecord& record : recorder->take_committed()) committed.push_back(std::move(record));
        return committed.size() == 20;
    });
    for (int n = 1; n <= 20; ++n) {
        EXPECT_EQ(committed[n - 1].id, n);
        EXPECT_EQ(committed[n - 1].mark.timestamp_us, sample_record(n).mark.timestamp_us);
    }
    EXPECT_EQ(ledger.count().value(), 20);
    EXPECT_TRUE(recorder->take_committed().empty());
    EXPECT_EQ(recorder->state().phase, RecorderPhase::ready);
    EXPECT_EQ(recorder->state().committed, 20);
    EXPECT_EQ(recorder->state().waiting, 0);
}

TEST_F(MarkRecorderTest, PostReturnsWhileTheWriterIsStuckInALock) {
    auto ledger = DefectLedger::open(file_, {60'000, true}).value();
    SQLite::Database other(file_.string(), SQLite::OPEN_READWRITE);
    other.exec("BEGIN IMMEDIATE");
    const auto recorder = start(ledger, 3);
    // The lock is released only below, so that these calls could not return if they waited for the disk.
    for (int n = 1; n <= 3; ++n) ASSERT_TRUE(recorder->post(sample_record(n)));
    const auto fourth = recorder->post(sample_record(4));
    ASSERT_FALSE(fourth);
    EXPECT_EQ(fourth.error().sentence, "the mark is not recorded: 3 marks already wait for the record");
    EXPECT_TRUE(recorder->take_committed().empty()) << "nothing may be acknowledged yet";
    EXPECT_EQ(recorder->state().waiting, 3);
    EXPECT_EQ(recorder->state().refused, 1);
    other.exec("COMMIT");
    wait_until([&] { return recorder->state().waiting == 0; });
    EXPECT_EQ(recorder->take_committed().size(), 3U);
}

TEST_F(MarkRecorderTest, TriesAgainUntilTheDiskHasRoom) {
    FailingDisk disk;
    auto ledger = DefectLedger::open(file_).value();
    const auto recorder = start(ledger, 2);
    disk.set(DiskFault::full);
    ASSERT_TRUE(recorder->post(sample_record(1)));
    ASSERT_TRUE(recorder->post(sample_record(2)));
    wait_until([&] { return recorder->state().phase == RecorderPhase::retrying; });
    EXPECT_THAT(recorder->state().reason, HasSubstr("the disk is full"));
    const auto third = recorder->post(sample_record(3));
    ASSERT_FALSE(third);
    EXPECT_THAT(third.error().sentence,
                HasSubstr("2 marks already wait for the record (cannot write a mark"));
    EXPECT_TRUE(recorder->take_committed().empty());
    disk.set(DiskFault::none);
    wait_until([&] { return recorder->state().phase == RecorderPhase::ready; });
    const auto committed = recorder->take_committed();
    ASSERT_EQ(committed.size(), 2U);
    EXPECT_EQ(committed[0].mark.timestamp_us, sample_record(1).mark.timestamp_us);
    EXPECT_TRUE(recorder->state().reason.empty());
}

TEST_F(MarkRecorderTest, HandsBackWhatItCouldNotWriteWhenStopped) {
    FailingDisk disk;
    auto ledger = DefectLedger::open(file_).value();
    MarkRecorderParams params;
    params.retry_first_ms = 1;
    params.stop_patience_ms = 20;
    const auto recorder = MarkRecorder::start(ledger, params).value();
    disk.set(DiskFault::full);
    for (int n = 1; n <= 3; ++n) ASSERT_TRUE(recorder->post(sample_record(n)));
    const auto left = recorder->stop();
    ASSERT_EQ(left.size(), 3U);
    EXPECT_EQ(left[2].mark.timestamp_us, sample_record(3).mark.timestamp_us);
    EXPECT_EQ(recorder->post(sample_record(4)).error().sentence,
              "the mark is not recorded: the station is stopping");
    EXPECT_TRUE(recorder->stop().empty());
}

TEST_F(MarkRecorderTest, StoppingWritesWhatWaits) {
    auto ledger = DefectLedger::open(file_).value();
    const auto recorder = start(ledger);
    for (int n = 1; n <= 10; ++n) ASSERT_TRUE(recorder->post(sample_record(n)));
    EXPECT_TRUE(recorder->stop().empty());
    EXPECT_EQ(ledger.count().value(), 10);
    EXPECT_EQ(recorder->take_committed().size(), 10U);
}

TEST_F(MarkRecorderTest, ABadMarkIsHandedBackAndBlocksNobody) {
    auto ledger = DefectLedger::open(file_).value();
    const auto recorder = start(ledger);
    DefectRecord bad = sample_record(1);
    bad.mark.confidence = 2;
    ASSERT_TRUE(recorder->post(bad));
    ASSERT_TRUE(recorder->post(sample_record(2)));
    wait_until([&] { return recorder->state().committed == 1; });
    const auto refused = recorder->take_refused();
    ASSERT_EQ(refused.size(), 1U);
    EXPECT_EQ(refused[0].sentence, "the mark is not recorded: its confidence is not 0 to 1");
    EXPECT_EQ(recorder->state().refused, 1);
    EXPECT_EQ(recorder->take_committed().at(0).id, 1);
}

TEST_F(MarkRecorderTest, CommitsAtOnceForReplay) {
    auto ledger = DefectLedger::open(file_).value();
    const auto recorder = start(ledger);
    for (int n = 1; n <= 3; ++n) EXPECT_EQ(recorder->commit_now(sample_record(n)).value(), n);
    EXPECT_TRUE(recorder->take_committed().empty()) << "the caller has its ids already";
    EXPECT_EQ(recorder->state().committed, 3);
    DefectRecord bad = sample_record();
    bad.source.clear();
    EXPECT_FALSE(recorder->commit_now(bad));
    EXPECT_EQ(recorder->state().phase, RecorderPhase::ready);
}

TEST_F(MarkRecorderTest, AFileTakenAwayShowsInTheState) {
    auto ledger = DefectLedger::open(file_).value();
    const auto recorder = start(ledger);
    std::filesystem::rename(file_, folder_ / "away.db");
    ASSERT_TRUE(recorder->post(sample_record()));
    wait_until([&] { return recorder->state().phase == RecorderPhase::retrying; });
    EXPECT_THAT(recorder->state().reason, HasSubstr("moved or deleted"));
    std::filesystem::rename(folder_ / "away.db", file_);
    wait_until([&] { return recorder->state().committed == 1; });
}

TEST_F(MarkRecorderTest, NotesWhatThePlcHasTaken) {
    auto ledger = DefectLedger::open(file_).value();
    const auto recorder = start(ledger);
    ASSERT_EQ(recorder->commit_now(sample_record()).value(), 1);
    recorder->note_delivered(7, 1);  // an id that is not there blocks nobody
    recorder->note_delivered(1, 1234);
    DefectFilter filter;
    filter.undelivered = true;
    wait_until([&] { return ledger.count(filter).value() == 0; });
    EXPECT_EQ(ledger.list().value()[0].delivered_us, 1234);
}

TEST_F(MarkRecorderTest, TakesMarksFromManyThreads) {
    auto ledger = DefectLedger::open(file_).value();
    const auto recorder = start(ledger, 1'000);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int n = 0; n < 25; ++n) {
                EXPECT_TRUE(recorder->post(sample_record(n)));
                recorder->state();
            }
        });
    for (std::thread& thread : threads) thread.join();
    wait_until([&] { return recorder->state().committed == 100; });
    EXPECT_EQ(recorder->take_committed().size(), 100U);
}

TEST_F(MarkRecorderTest, ChecksItsSettings) {
    auto ledger = DefectLedger::open(file_).value();
    MarkRecorderParams params;
    EXPECT_TRUE(params.validate().empty());
    params.retry_first_ms = 5'000;
    const auto recorder = MarkRecorder::start(ledger, params);
    ASSERT_FALSE(recorder);
    EXPECT_EQ(recorder.error().sentence,
              "the setting record.retry_longest_ms is 2000.000000; expected 5000.000000 to 60000.000000");
}

}  // namespace
}  // namespace deixis
