// Another program run beside a test: started, listened to line by line, signalled, ended.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace deixis {

class ChildProgram {
  public:
    /// Starts `arguments[0]` (an absolute path) with its standard output and errors read by this object.
    explicit ChildProgram(const std::vector<std::string>& arguments);
    ~ChildProgram();  ///< kill -9

    /// The next line that begins with `prefix`, without the prefix; nullopt when none comes within
    /// `patience`.
    std::optional<std::string> line(const std::string& prefix,
                                    std::chrono::seconds patience = std::chrono::seconds(20));

    void signal(int number) const;

    /// Waits for its end and returns the exit code; -1 when a signal ended it.
    int wait();

    /// All that it has said so far.
    const std::string& said() const { return said_; }

    ChildProgram(const ChildProgram&) = delete;
    ChildProgram& operator=(const ChildProgram&) = delete;

  private:
    bool read_more(int patience_ms);
    pid_t pid_ = 0;
    int output_ = -1;
    std::string said_;
    size_t looked_at_ = 0;
};

/// Runs a program to its end; returns its exit code and what it said.
std::pair<int, std::string> run_program(const std::vector<std::string>& arguments);

/// Tries `done` until it is true, at most 20 s.
template <class Condition>
bool eventually(Condition done) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!done()) {
        if (std::chrono::steady_clock::now() > deadline) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
}

}  // namespace deixis
