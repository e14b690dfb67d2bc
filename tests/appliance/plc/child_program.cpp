// posix_spawn and one pipe.
#include "tests/appliance/plc/child_program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

extern char** environ;

namespace deixis {

ChildProgram::ChildProgram(const std::vector<std::string>& arguments) {
    int ends[2];
    EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    std::vector<std::string> copies = arguments;
    std::vector<char*> pointers;
    for (std::string& copy : copies) pointers.push_back(copy.data());
    pointers.push_back(nullptr);
    EXPECT_EQ(posix_spawn(&pid_, copies[0].c_str(), &actions, nullptr, pointers.data(), environ), 0)
        << copies[0];
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    output_ = ends[0];
}

ChildProgram::~ChildProgram() {
    if (pid_ > 0) {
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }
    ::close(output_);
}

bool ChildProgram::read_more(int patience_ms) {
    pollfd readable{output_, POLLIN, 0};
    if (::poll(&readable, 1, patience_ms) <= 0) return false;
    char buffer[4096];
    const ssize_t got = ::read(output_, buffer, sizeof buffer);
    if (got <= 0) return false;
    said_.append(buffer, static_cast<size_t>(got));
    return true;
}

std::optional<std::string> ChildProgram::line(const std::string& prefix, std::chrono::seconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    for (;;) {
        for (size_t end = 0; (end = said_.find('\n', looked_at_)) != std::string::npos;) {
            const std::string found = said_.substr(looked_at_, end - looked_at_);
            looked_at_ = end + 1;
            if (found.starts_with(prefix)) return found.substr(prefix.size());
        }
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now())
                .count();
        if (left <= 0 || !read_more(static_cast<int>(left))) return std::nullopt;
    }
}

void ChildProgram::signal(int number) const {
    ::kill(pid_, number);
}

int ChildProgram::wait() {
    while (read_more(20'000)) {
    }
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::pair<int, std::string> run_program(const std::vector<std::string>& arguments) {
    ChildProgram program(arguments);
    const int code = program.wait();
    return {code, program.said()};
}

}  // namespace deixis
