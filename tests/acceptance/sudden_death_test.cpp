// `kill -9` of the station at random moments of a replay, 50 times: every acknowledged mark is in the record,
// and the record is whole.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <set>

#include "tests/acceptance/watched_program.h"

namespace deixis {
namespace {

using Clock = std::chrono::steady_clock;

std::string session_folder() {
    const char* folder = std::getenv("DEIXIS_SESSION");
    return folder == nullptr ? "" : folder;
}

std::set<int64_t> acknowledged_in(const std::vector<std::string>& lines) {
    std::set<int64_t> ids;
    for (const std::string& line : lines) {
        if (line.starts_with("MARK ")) ids.insert(std::strtoll(line.c_str() + 5, nullptr, 10));
    }
    return ids;
}

std::set<int64_t> recorded_in(const std::string& database) {
    std::set<int64_t> ids;
    if (!std::filesystem::exists(database)) return ids;
    SQLite::Database record(database, SQLite::OPEN_READWRITE);  // as a restarted station: plays the log back
    EXPECT_EQ(record.execAndGet("PRAGMA integrity_check").getString(), "ok");
    if (!record.tableExists("defect")) return ids;
    SQLite::Statement query(record, "SELECT id FROM defect");
    while (query.executeStep()) ids.insert(query.getColumn(0).getInt64());
    return ids;
}

std::vector<std::string> replay_into(const std::string& database, const std::string& results) {
    return {"deixis", "replay", session_folder(), "--results", results, "--database", database};
}

TEST(SuddenDeath, LosesNoAcknowledgedMarkInFiftyKills) {
    ASSERT_FALSE(session_folder().empty());
    const std::string folder = testing::TempDir() + "/sudden_death";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);

    // An undisturbed run says how many marks there are to lose.
    WatchedProgram whole(replay_into(folder + "/whole.db", folder + "/whole.jsonl"));
    ASSERT_EQ(whole.wait(), 0);
    const std::set<int64_t> all = acknowledged_in(whole.lines());
    ASSERT_GE(all.size(), 2U) << "the session has too few marks for this test";
    ASSERT_EQ(recorded_in(folder + "/whole.db"), all);

    std::mt19937 random(2014);
    size_t acknowledged_before_death = 0, died = 0;
    for (int round = 0; round < 50; ++round) {
        SCOPED_TRACE("kill " + std::to_string(round));
        const std::string database = folder + "/killed.db";
        for (const char* ending : {"", "-wal", "-shm"}) std::filesystem::remove(database + ending);
        WatchedProgram program(replay_into(database, folder + "/killed.jsonl"));
        if (round % 2 == 0) {  // any moment, start-up included: told by the replay's progress, not by a clock
            const int percent = 5 * std::uniform_int_distribution<>(0, 18)(random);
            const auto reached = [&](const std::string& line) {
                return line.starts_with("PROGRESS ") && std::atoi(line.c_str() + 9) >= percent;
            };
            if (percent > 0) {
                ASSERT_TRUE(program.wait_for(reached, std::chrono::seconds(120)));
            }
            const int longest_ms = percent > 0 ? 300 : 2000;
            const auto moment = Clock::now() + std::chrono::milliseconds(
                                                   std::uniform_int_distribution<>(0, longest_ms)(random));
            while (program.next_line(moment)) {
            }
        } else {  // around an acknowledgement, where a mark is most at risk
            const auto wanted = std::uniform_int_distribution<int64_t>(1, int64_t(all.size()))(random);
            const std::string line = "MARK " + std::to_string(wanted) + " ";
            ASSERT_TRUE(program.wait_for([&](const std::string& l) { return l.starts_with(line); },
                                         std::chrono::seconds(120)));
            const auto moment =
                Clock::now() + std::chrono::microseconds(std::uniform_int_distribution<>(0, 3000)(random));
            while (program.next_line(moment)) {
            }
        }
        program.send(SIGKILL);
        if (program.wait() == 128 + SIGKILL) ++died;
        const std::set<int64_t> acknowledged = acknowledged_in(program.lines());  // the pipe's rest included
        const std::set<int64_t> recorded = recorded_in(database);
        for (const int64_t id : acknowledged)
            EXPECT_TRUE(recorded.contains(id)) << "mark " << id << " is lost";
        acknowledged_before_death += acknowledged.size();
    }
    EXPECT_GE(died, 45U) << "most runs must have been killed in mid-run";
    EXPECT_GE(acknowledged_before_death, 25U);
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace deixis
