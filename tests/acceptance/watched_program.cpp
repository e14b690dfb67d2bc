// fork, exec, a pipe for the output, and /proc for the children.
#include "tests/acceptance/watched_program.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace deixis {

namespace {

std::string program_in_bin(const std::string& name) {
    const char* folder = std::getenv("DEIXIS_BIN");
    return (folder == nullptr ? std::string("bin") : std::string(folder)) + "/" + name;
}

std::string file_text(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

WatchedProgram::WatchedProgram(const std::vector<std::string>& arguments) {
    std::vector<std::string> words = arguments;
    words[0] = program_in_bin(words[0]);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    process_ = fork();
    if (process_ == 0) {
        setpgid(0, 0);
        dup2(ends[1], STDOUT_FILENO);
        dup2(ends[1], STDERR_FILENO);
        execv(pointers[0], pointers.data());
        _exit(127);
    }
    close(ends[1]);
    output_ = ends[0];
    if (process_ < 0) throw std::runtime_error("no process");
    setpgid(process_, process_);  // also here: whoever comes first
}

WatchedProgram::~WatchedProgram() {
    if (process_ > 0) {
        kill(-process_, SIGKILL);
        kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
    }
    close(output_);
}

std::optional<std::string> WatchedProgram::next_line(std::chrono::steady_clock::time_point deadline) {
    for (;;) {
        const size_t end = pending_.find('\n');
        if (end != std::string::npos) {
            lines_.push_back(pending_.substr(0, end));
            pending_.erase(0, end + 1);
            return lines_.back();
        }
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
            deadline - std::chrono::steady_clock::now());
        pollfd ready{output_, POLLIN, 0};
        if (left.count() <= 0 || poll(&ready, 1, static_cast<int>(left.count())) <= 0) return std::nullopt;
        std::array<char, 4096> piece{};
        const ssize_t got = read(output_, piece.data(), piece.size());
        if (got <= 0) return std::nullopt;
        pending_.append(piece.data(), static_cast<size_t>(got));
    }
}

std::optional<std::string> WatchedProgram::wait_for(const std::function<bool(const std::string&)>& wanted,
                                                    std::chrono::seconds patience) {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    while (auto line = next_line(deadline)) {
        if (wanted(*line)) return line;
    }
    return std::nullopt;
}

std::vector<pid_t> WatchedProgram::children_with(const std::string& part) const {
    std::vector<pid_t> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
        const std::string name = entry.path().filename();
        if (!std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; })) continue;
        const std::string stat = file_text("/proc/" + name + "/stat");
        const size_t after_name = stat.rfind(')');  // "pid (name) state parent ..."
        if (after_name == std::string::npos || after_name + 4 >= stat.size()) continue;
        if (std::strtol(stat.c_str() + after_name + 4, nullptr, 10) != process_) continue;
        std::string command = file_text("/proc/" + name + "/cmdline");
        std::replace(command.begin(), command.end(), '\0', ' ');
        if (command.find(part) != std::string::npos) found.push_back(static_cast<pid_t>(std::stol(name)));
    }
    return found;
}

void WatchedProgram::send(int signal) const {
    kill(process_, signal);
}

int WatchedProgram::wait() {
    while (next_line(std::chrono::steady_clock::now() + std::chrono::minutes(10))) {
    }
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace deixis
