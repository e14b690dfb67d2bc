// Children of the system's own shell: bell, end, hygiene, refusals.
#include "appliance/sensors/child_process.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "appliance/sensors/host_clock.h"

namespace deixis {
namespace {

using testing::HasSubstr;

Result<ChildProcess> shell(const std::string& script,
                           std::vector<std::pair<std::string, std::string>> environment = {}) {
    return ChildProcess::start({"/bin/sh", {"-c", script}, std::move(environment)});
}

/// How the child ended, waiting at most 10 s.
std::string end_of(ChildProcess& child) {
    const int64_t deadline = host_now_us() + 10'000'000;
    while (!child.ended() && host_now_us() < deadline) std::this_thread::yield();
    return child.ended().value_or("still runs");
}

bool rings(const ChildProcess& child) {
    pollfd bell = {child.bell(), POLLIN, 0};
    return poll(&bell, 1, 10'000) == 1 && (bell.revents & POLLIN) != 0;
}

TEST(ChildProcess, TellsHowItEnded) {
    auto good = shell("exit 0"), bad = shell("exit 7"), killed = shell("kill -9 $$");
    ASSERT_TRUE(good && bad && killed);
    EXPECT_EQ(end_of(*good), "ended with code 0");
    EXPECT_EQ(end_of(*bad), "ended with code 7");
    EXPECT_EQ(end_of(*killed), "was killed by signal 9 (Killed)");
}

TEST(ChildProcess, RingsTheBell) {
    auto child = shell("printf x >&3; sleep 60");
    ASSERT_TRUE(child);
    EXPECT_TRUE(rings(*child));
    child->hush();
    pollfd bell = {child->bell(), POLLIN, 0};
    EXPECT_EQ(poll(&bell, 1, 0), 0);
    EXPECT_FALSE(child->ended());
    child->ask_to_end();
    EXPECT_EQ(end_of(*child), "was killed by signal 15 (Terminated)");
}

TEST(ChildProcess, IsKilledEvenWhenStopped) {
    auto child = shell("printf x >&3; kill -STOP $$");
    ASSERT_TRUE(child);
    ASSERT_TRUE(rings(*child));
    child->kill();
    EXPECT_EQ(end_of(*child), "was killed by signal 9 (Killed)");
}

TEST(ChildProcess, EndsWithItsOwner) {
    int process_id = 0;
    {
        auto child = shell("sleep 60");
        ASSERT_TRUE(child);
        process_id = child->process_id();
        EXPECT_EQ(kill(process_id, 0), 0);
    }
    EXPECT_EQ(kill(process_id, 0), -1);
}

TEST(ChildProcess, GetsTheHangUpWhenItsParentIsKilled) {
    int report[2];
    ASSERT_EQ(pipe(report), 0);
    const pid_t station = fork();
    if (station == 0) {
        auto child = shell("printf x >&3; sleep 60");
        if (!child || !rings(*child)) _exit(1);
        const int id = child->process_id();
        if (write(report[1], &id, sizeof id) != sizeof id) _exit(1);
        kill(getpid(), SIGKILL);
    }
    int child = 0;
    ASSERT_EQ(read(report[0], &child, sizeof child), static_cast<ssize_t>(sizeof child));
    waitpid(station, nullptr, 0);
    // Nobody may reap it here; gone or a zombie is what "ended" means.
    const auto lives = [&] {
        std::ifstream stat("/proc/" + std::to_string(child) + "/stat");
        std::string line;
        return std::getline(stat, line) && line.find(") Z") == std::string::npos;
    };
    const int64_t deadline = host_now_us() + 10'000'000;
    while (lives() && host_now_us() < deadline) std::this_thread::yield();
    EXPECT_FALSE(lives());
    close(report[0]);
    close(report[1]);
}

TEST(ChildProcess, InheritsNoFilesButTheFirstThreeAndTheBell) {
    const int stray = open("/etc/passwd", O_RDONLY);  // without close-on-exec, as a library might
    auto child = shell(
        "for f in /proc/$$/fd/*; do [ \"$(readlink $f)\" = /etc/passwd ] && exit 1; done; "
        "[ -p /proc/$$/fd/3 ]");
    ASSERT_TRUE(child);
    EXPECT_EQ(end_of(*child), "ended with code 0");
    close(stray);
}

TEST(ChildProcess, IgnoresTheCtrlCOfTheTerminal) {
    auto child = shell("printf x >&3; kill -INT $$; exit 5");
    ASSERT_TRUE(child);
    EXPECT_EQ(end_of(*child), "ended with code 5");
}

TEST(ChildProcess, SetsItsEnvironmentOnTopOfOurs) {
    auto child = shell("[ \"$DEIXIS_TEST\" = 'a b' ] && [ -n \"$PATH\" ]", {{"DEIXIS_TEST", "a b"}});
    ASSERT_TRUE(child);
    EXPECT_EQ(end_of(*child), "ended with code 0");
}

TEST(ChildProcess, RefusesWhatIsNoProgram) {
    for (const char* program : {"/no/such/program", "/tmp", "/etc/passwd", ""}) {
        const auto child = ChildProcess::start({program, {}, {}});
        ASSERT_FALSE(child) << program;
        EXPECT_EQ(
            child.error().sentence,
            std::string(program) + ": cannot be started as a sensor process, expected an executable file");
    }
}

}  // namespace
}  // namespace deixis
