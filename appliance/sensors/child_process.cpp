// Start and end of a child process. In: a command; out: a process id and a bell to wait on.
#include "appliance/sensors/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace deixis {
namespace {

constexpr int bell_in_child = 3;

std::string describe(int status) {
    if (WIFSIGNALED(status)) {
        const int number = WTERMSIG(status);
        return "was killed by signal " + std::to_string(number) + " (" + strsignal(number) + ")";
    }
    return "ended with code " + std::to_string(WEXITSTATUS(status));
}

/// Between fork and exec: only calls that are safe after the fork of a program with threads.
[[noreturn]] void become(const char* program, char* const* arguments, char* const* environment, int bell,
                         pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGHUP);
    if (getppid() != parent) _exit(127);
    if (bell == bell_in_child)
        fcntl(bell, F_SETFD, 0);
    else
        dup2(bell, bell_in_child);
    close_range(bell_in_child + 1, ~0U, 0);
    struct sigaction action = {};
    action.sa_handler = SIG_DFL;
    for (const int number : {SIGTERM, SIGHUP, SIGPIPE, SIGUSR1, SIGUSR2, SIGCHLD})
        sigaction(number, &action, nullptr);
    action.sa_handler = SIG_IGN;
    sigaction(SIGINT, &action, nullptr);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    execve(program, arguments, environment);
    _exit(127);
}

std::vector<char*> pointers_to(std::vector<std::string>& strings) {
    std::vector<char*> pointers;
    pointers.reserve(strings.size() + 1);
    for (std::string& s : strings) pointers.push_back(s.data());
    pointers.push_back(nullptr);
    return pointers;
}

}  // namespace

Result<ChildProcess> ChildProcess::start(const ChildCommand& command) {
    const std::string program = command.program.string();
    if (access(program.c_str(), X_OK) != 0 || !std::filesystem::is_regular_file(command.program))
        return fail(program + ": cannot be started as a sensor process, expected an executable file");

    std::vector<std::string> arguments = {program};
    arguments.insert(arguments.end(), command.arguments.begin(), command.arguments.end());
    std::vector<std::string> environment;
    environment.reserve(command.environment.size());
    for (const auto& [key, value] : command.environment)
        environment.emplace_back(key).append("=").append(value);
    for (char** entry = environ; *entry != nullptr; ++entry) {
        const std::string line = *entry;
        bool replaced = false;
        for (const auto& [key, value] : command.environment) replaced |= line.starts_with(key + "=");
        if (!replaced) environment.push_back(line);
    }
    const std::vector<char*> argument_pointers = pointers_to(arguments);
    const std::vector<char*> environment_pointers = pointers_to(environment);

    int bell[2];
    if (pipe2(bell, O_CLOEXEC | O_NONBLOCK) != 0)
        return fail(program + ": no pipe for its door bell: " + std::generic_category().message(errno));
    const pid_t parent = getpid();
    const pid_t pid = fork();
    if (pid == 0)
        become(program.c_str(), argument_pointers.data(), environment_pointers.data(), bell[1], parent);
    const int error = errno;
    close(bell[1]);
    if (pid < 0) {
        close(bell[0]);
        return fail(program + ": cannot be started: " + std::generic_category().message(error));
    }
    ChildProcess child;
    child.pid_ = pid;
    child.bell_ = bell[0];
    return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept {
    *this = std::move(other);
}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
    std::swap(pid_, other.pid_);
    std::swap(bell_, other.bell_);
    std::swap(end_, other.end_);
    return *this;
}

ChildProcess::~ChildProcess() {
    kill();
    if (bell_ >= 0) close(bell_);
}

void ChildProcess::hush() {
    char bytes[256];
    while (read(bell_, bytes, sizeof bytes) == static_cast<ssize_t>(sizeof bytes)) {
    }
}

const std::optional<std::string>& ChildProcess::ended() {
    if (pid_ == 0 || end_) return end_;
    int status = 0;
    const pid_t answer = waitpid(pid_, &status, WNOHANG);
    if (answer == pid_) end_ = describe(status);
    if (answer < 0 && errno == ECHILD) end_ = "was reaped by someone else";
    return end_;
}

void ChildProcess::ask_to_end() {
    if (pid_ != 0 && !ended()) ::kill(pid_, SIGTERM);
}

void ChildProcess::kill() {
    if (pid_ == 0 || ended()) return;
    ::kill(pid_, SIGKILL);
    // A process stuck in a driver cannot be reaped yet: nobody waits for it, a later `ended` finds it.
    for (int i = 0; i < 100 && !ended(); ++i) usleep(1000);
}

}  // namespace deixis
