// What goes into the ledger comes out of it: records, states, histories, filters; and what it refuses.
#include "appliance/records/defect_ledger.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <thread>

#include "appliance/records/utc_time.h"
#include "tests/appliance/records/ledger_fixture.h"

namespace deixis {
namespace {

using ::testing::HasSubstr;
using DefectLedgerTest = LedgerFolder;

void expect_same(const DefectRecord& a, const DefectRecord& b) {
    EXPECT_EQ(a.part_type, b.part_type);
    EXPECT_EQ(a.part_serial, b.part_serial);
    EXPECT_EQ(a.mark.timestamp_us, b.mark.timestamp_us);
    EXPECT_EQ(a.mark.spot.position, b.mark.spot.position);  // bit for bit
    EXPECT_EQ(a.mark.spot.normal, b.mark.spot.normal);
    EXPECT_EQ(a.mark.arm, b.mark.arm);
    EXPECT_EQ(a.mark.confidence, b.mark.confidence);
    EXPECT_EQ(a.mark.touch, b.mark.touch);
    EXPECT_EQ(a.zone, b.zone);
    EXPECT_EQ(a.time_us, b.time_us);
    EXPECT_EQ(a.state, b.state);
    EXPECT_EQ(a.source, b.source);
}

TEST_F(DefectLedgerTest, KeepsEveryFieldAcrossClosingAndOpening) {
    std::vector<DefectRecord> written;
    for (int n = 1; n <= 6; ++n) {
        DefectRecord record = sample_record(n);
        record.part_serial = std::to_string(n % 2);
        record.mark.spot.position.x() = std::nextafter(0.1 * n, 1.0);
        record.state = n == 5 ? DefectState::confirmed : DefectState::open;
        record.source = n == 6 ? "session-7" : "live";
        written.push_back(record);
    }
    {
        auto ledger = DefectLedger::open(file_);
        ASSERT_TRUE(ledger) << ledger.error().sentence;
        for (size_t i = 0; i < written.size(); ++i) EXPECT_EQ(ledger->commit(written[i]).value(), i + 1);
    }
    const auto ledger = DefectLedger::open_to_read(file_);
    ASSERT_TRUE(ledger) << ledger.error().sentence;
    const auto read = ledger->list().value();
    ASSERT_EQ(read.size(), written.size());
    for (size_t i = 0; i < read.size(); ++i) {
        EXPECT_EQ(read[i].id, i + 1);
        EXPECT_FALSE(read[i].delivered_us);
        expect_same(read[i], written[i]);
    }
    EXPECT_TRUE(ledger->integrity_complaints().value().empty());
}

TEST_F(DefectLedgerTest, KeepsTextsByteByByte) {
    auto ledger = DefectLedger::open(file_).value();
    for (const std::string& text :
         {std::string("it's \"quoted\"; DROP TABLE defect;--"), std::string("a\0b", 3),
          std::string("\xff\xfe\x80"), std::string("line\r\nline"), std::string(), std::string(4096, 'x'),
          std::string("\xe4\xb8\xad\xe6\x96\x87")}) {
        DefectRecord record = sample_record();
        record.part_serial = record.part_type = record.zone = text;
        const DefectId id = ledger.commit(record).value();
        DefectFilter filter;
        filter.part_serial = text;
        const auto found = ledger.list(filter).value();
        ASSERT_EQ(found.size(), 1U);
        EXPECT_EQ(found[0].id, id);
        expect_same(found[0], record);
    }
}

TEST_F(DefectLedgerTest, IsSetUpForPowerCuts) {
    auto ledger = DefectLedger::open(file_).value();
    ASSERT_TRUE(ledger.commit(sample_record()));
    const auto facts = DefectLedger::inspect(file_).value();
    EXPECT_TRUE(facts.write_ahead_log);
    EXPECT_EQ(facts.tables_version, DefectLedger::schema_version);
    EXPECT_EQ(facts.defects, 1);
    EXPECT_TRUE(facts.complaints.empty());
    SQLite::Database peer(file_.string(), SQLite::OPEN_READWRITE);
    peer.exec("PRAGMA foreign_keys = ON");
    EXPECT_THROW(peer.exec("DELETE FROM part"), SQLite::Exception) << "a part with defects must stay";
}

TEST_F(DefectLedgerTest, NeverGivesAnIdTwice) {
    {
        auto ledger = DefectLedger::open(file_).value();
        for (int n = 1; n <= 3; ++n) ASSERT_TRUE(ledger.commit(sample_record(n)));
    }
    {
        SQLite::Database peer(file_.string(), SQLite::OPEN_READWRITE);
        peer.exec("DELETE FROM state_change; DELETE FROM defect");
    }
    EXPECT_EQ(DefectLedger::open(file_).value().commit(sample_record()).value(), 4);
}

TEST_F(DefectLedgerTest, FiltersAsAPlainLoopDoes) {
    auto ledger = DefectLedger::open(file_).value();
    std::vector<DefectRecord> all;
    for (int n = 0; n < 60; ++n) {
        DefectRecord record = sample_record(n);
        record.part_type = n % 3 == 0 ? "a" : "b";
        record.part_serial = std::to_string(n % 4);
        record.source = n % 5 == 0 ? "s1" : "live";
        record.state = static_cast<DefectState>(n % 3);
        record.time_us = 1'000'000LL * ((n * 7) % 60);
        record.id = ledger.commit(record).value();
        if (n % 2 == 0) {
            ASSERT_TRUE(ledger.set_delivered(record.id, 5));
            record.delivered_us = 5;
        }
        all.push_back(record);
    }
    for (int trial = 0; trial < 256; ++trial) {
        DefectFilter filter;
        if (trial & 1) filter.since_us = 20'000'000;
        if (trial & 2) filter.until_us = 40'000'000;
        if (trial & 4) filter.part_type = "b";
        if (trial & 8) filter.part_serial = "1";
        if (trial & 16) filter.source = "live";
        if (trial & 32) filter.state = DefectState::confirmed;
        if (trial & 64) filter.undelivered = true;
        if (trial & 128) filter.after = 30;
        std::vector<DefectId> expected;
        for (const DefectRecord& r : all)
            if ((!filter.since_us || r.time_us >= *filter.since_us) &&
                (!filter.until_us || r.time_us < *filter.until_us) &&
                (!filter.part_type || r.part_type == *filter.part_type) &&
                (!filter.part_serial || r.part_serial == *filter.part_serial) &&
                (!filter.source || r.source == *filter.source) &&
                (!filter.state || r.state == *filter.state) && (!filter.undelivered || !r.delivered_us) &&
                r.id > filter.after)
                expected.push_back(r.id);
        std::vector<DefectId> found;
        const auto listed = ledger.list(filter).value();
        for (const DefectRecord& r : listed) found.push_back(r.id);
        ASSERT_EQ(found, expected) << "trial " << trial;
        ASSERT_EQ(ledger.count(filter).value(), expected.size());
        filter.limit = 2;
        ASSERT_EQ(ledger.list(filter).value().size(), std::min<size_t>(2, expected.size()));
        ASSERT_EQ(ledger.count(filter).value(), std::min<size_t>(2, expected.size()));
    }
}

TEST_F(DefectLedgerTest, WritesDownWhoChangedAStateAndWhen) {
    auto ledger = DefectLedger::open(file_).value();
    const DefectRecord record = sample_record();
    const DefectId id = ledger.commit(record).value();
    ASSERT_TRUE(ledger.set_state(id, DefectState::confirmed, "inspector", 10));
    ASSERT_TRUE(ledger.set_state(id, DefectState::confirmed, "somebody else", 20)) << "no change, no line";
    ASSERT_TRUE(ledger.set_state(id, DefectState::withdrawn, "it's \"me\"", 30));
    EXPECT_EQ(ledger.list().value()[0].state, DefectState::withdrawn);
    const auto history = ledger.history(id).value();
    ASSERT_EQ(history.size(), 3U);
    EXPECT_EQ(history[0].who, "station");
    EXPECT_EQ(history[0].state, DefectState::open);
    EXPECT_EQ(history[0].time_us, record.time_us);
    EXPECT_EQ(history[1].who, "inspector");
    EXPECT_EQ(history[1].state, DefectState::confirmed);
    EXPECT_EQ(history[2].who, "it's \"me\"");
    EXPECT_EQ(history[2].time_us, 30);
    EXPECT_EQ(ledger.set_state(99, DefectState::open, "me", 0).error().sentence, "there is no defect 99");
    EXPECT_EQ(ledger.set_state(id, DefectState::open, "", 0).error().sentence,
              "the state of defect 1 is not changed: who did it must be told");
    EXPECT_EQ(ledger.list().value()[0].state, DefectState::withdrawn);
}

TEST_F(DefectLedgerTest, NotesTheFirstEchoOnly) {
    auto ledger = DefectLedger::open(file_).value();
    const DefectId id = ledger.commit(sample_record()).value();
    ASSERT_TRUE(ledger.set_delivered(id, 77));
    ASSERT_TRUE(ledger.set_delivered(id, 99));
    EXPECT_EQ(ledger.list().value()[0].delivered_us, 77);
    EXPECT_EQ(ledger.set_delivered(5, 1).error().sentence, "there is no defect 5");
}

TEST_F(DefectLedgerTest, RefusesRecordsThatAreNotWhole) {
    auto ledger = DefectLedger::open(file_).value();
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinite = std::numeric_limits<double>::infinity();
    const std::string too_long(4097, 'x');
    const struct {
        std::function<void(DefectRecord&)> spoil;
        const char* sentence;
    } cases[] = {
        {[&](DefectRecord& r) { r.mark.spot.position.x() = nan; }, "its position is not finite"},
        {[&](DefectRecord& r) { r.mark.spot.position.y() = infinite; }, "its position is not finite"},
        {[&](DefectRecord& r) { r.mark.spot.position.z() = -infinite; }, "its position is not finite"},
        {[&](DefectRecord& r) { r.mark.spot.normal.x() = nan; }, "its normal is not finite"},
        {[&](DefectRecord& r) { r.mark.spot.normal.z() = infinite; }, "its normal is not finite"},
        {[&](DefectRecord& r) { r.mark.confidence = nan; }, "its confidence is not 0 to 1"},
        {[&](DefectRecord& r) { r.mark.confidence = -0.001; }, "its confidence is not 0 to 1"},
        {[&](DefectRecord& r) { r.mark.confidence = 1.001; }, "its confidence is not 0 to 1"},
        {[&](DefectRecord& r) { r.time_us = latest_utc_us + 1; }, "its time is not in the years 1 to 9999"},
        {[&](DefectRecord& r) { r.time_us = earliest_utc_us - 1; }, "its time is not in the years 1 to 9999"},
        {[&](DefectRecord& r) { r.source.clear(); }, "its source is empty"},
        {[&](DefectRecord& r) { r.zone = too_long; }, "a text of it has more than 4096 bytes"},
        {[&](DefectRecord& r) { r.part_type = too_long; }, "a text of it has more than 4096 bytes"},
        {[&](DefectRecord& r) { r.part_serial = too_long; }, "a text of it has more than 4096 bytes"},
        {[&](DefectRecord& r) { r.source = too_long; }, "a text of it has more than 4096 bytes"},
    };
    for (const auto& spoiled : cases) {
        DefectRecord record = sample_record();
        spoiled.spoil(record);
        const auto id = ledger.commit(record);
        ASSERT_FALSE(id) << spoiled.sentence;
        EXPECT_EQ(id.error().trouble, LedgerTrouble::refused);
        EXPECT_EQ(id.error().sentence, std::string("the mark is not recorded: ") + spoiled.sentence);
    }
    EXPECT_EQ(ledger.count().value(), 0);
}

TEST_F(DefectLedgerTest, TakesManyThreadsAndConnections) {
    auto shared = DefectLedger::open(file_).value();
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            auto own = DefectLedger::open(file_, {30'000, false});
            ASSERT_TRUE(own) << own.error().sentence;
            for (int n = 0; n < 10; ++n) {
                auto& ledger = t % 2 == 0 ? shared : *own;
                const auto id = ledger.commit(sample_record(n));
                ASSERT_TRUE(id) << id.error().sentence;
                ASSERT_TRUE(ledger.list().has_value());
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(shared.count().value(), 40);
    EXPECT_TRUE(shared.integrity_complaints().value().empty());
}

TEST_F(DefectLedgerTest, ChecksItsSettings) {
    LedgerParams params;
    EXPECT_TRUE(params.validate().empty());
    params.busy_timeout_ms = -1;
    ASSERT_EQ(params.validate().size(), 1U);
    EXPECT_EQ(params.validate()[0].key, "busy_timeout_ms");
}

TEST(DefectState, HasANameForEveryStateAndBack) {
    for (const DefectState state : {DefectState::open, DefectState::confirmed, DefectState::withdrawn})
        EXPECT_EQ(defect_state_of(name_of(state)), state);
    EXPECT_FALSE(defect_state_of("Open"));
    EXPECT_FALSE(defect_state_of(""));
}

}  // namespace
}  // namespace deixis
