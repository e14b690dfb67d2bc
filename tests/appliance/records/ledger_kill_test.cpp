// Promise 1: kill -9 at any instant loses no acknowledged mark and leaves a database that opens.
#include <gmock/gmock.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <random>
#include <set>

#include "tests/appliance/records/ledger_fixture.h"

extern char** environ;

namespace deixis {
namespace {

/// The ids that a committing child acknowledged before it was killed `after` the first one.
std::vector<DefectId> commit_until_killed(const std::filesystem::path& file,
                                          std::chrono::microseconds after) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    std::string program = COMMITTING_CHILD, database = file.string();
    char* arguments[] = {program.data(), database.data(), nullptr};
    pid_t child = 0;
    EXPECT_EQ(posix_spawn(&child, program.c_str(), &actions, nullptr, arguments, environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);

    std::string said;
    char buffer[4096];
    bool killed = false;
    const auto started = std::chrono::steady_clock::now();
    auto kill_at =
        started + std::chrono::seconds(20);  // a child that never commits ends the wait, and the test
    for (;;) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(kill_at - std::chrono::steady_clock::now());
        pollfd readable{ends[0], POLLIN, 0};
        if (!killed && (left.count() <= 0 || ::poll(&readable, 1, static_cast<int>(left.count())) == 0)) {
            ::kill(child, SIGKILL);
            killed = true;
        }
        const ssize_t got = ::read(ends[0], buffer, sizeof buffer);
        if (got <= 0) break;
        if (said.empty()) kill_at = std::chrono::steady_clock::now() + after;
        said.append(buffer, static_cast<size_t>(got));
    }
    ::close(ends[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
        << "the child ended by itself: " << status;

    std::vector<DefectId> ids;
    for (size_t at = 0, end = 0; (end = said.find('\n', at)) != std::string::npos; at = end + 1)
        ids.push_back(std::stoll(said.substr(at, end - at)));
    return ids;
}

class LedgerKillTest : public LedgerFolder {
    std::filesystem::path root() const override {
        return std::filesystem::temp_directory_path();
    }  // a real disk
};

TEST_F(LedgerKillTest, FiftyKillsLoseNoAcknowledgedMark) {
    std::mt19937 random(2);
    std::uniform_int_distribution<int> pause_us(0, 30'000);
    std::set<DefectId> acknowledged;
    for (int kill = 0; kill < 50; ++kill) {
        const auto ids = commit_until_killed(file_, std::chrono::microseconds(pause_us(random)));
        ASSERT_FALSE(ids.empty());
        for (const DefectId id : ids)
            EXPECT_TRUE(acknowledged.insert(id).second) << "id " << id << " given twice";
        const auto ledger = DefectLedger::open(file_);
        ASSERT_TRUE(ledger) << ledger.error().sentence;
        EXPECT_TRUE(ledger->integrity_complaints().value().empty());
        std::set<DefectId> kept;
        const auto records = ledger->list().value();
        for (const DefectRecord& record : records) kept.insert(record.id);
        for (const DefectId id : acknowledged) ASSERT_TRUE(kept.contains(id)) << "mark " << id << " is lost";
        // At most the one commit that was under way is there without having been acknowledged.
        ASSERT_LE(kept.size(), acknowledged.size() + kill + 1);
    }
    RecordProperty("acknowledged", static_cast<int>(acknowledged.size()));
}

}  // namespace
}  // namespace deixis
