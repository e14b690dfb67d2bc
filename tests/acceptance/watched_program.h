// A program of ours run from outside: its lines as they come, its end, and signals to it or its children.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace deixis {

/// Killed and reaped with its children's process group when it goes out of scope.
class WatchedProgram {
  public:
    /// Starts `$DEIXIS_BIN/<arguments[0]>` in a process group of its own; standard error joins standard
    /// output.
    explicit WatchedProgram(const std::vector<std::string>& arguments);
    WatchedProgram(const WatchedProgram&) = delete;
    WatchedProgram& operator=(const WatchedProgram&) = delete;
    ~WatchedProgram();

    /// The next complete line; nothing at the end of the output or when `deadline` passes first.
    std::optional<std::string> next_line(std::chrono::steady_clock::time_point deadline);

    /// Reads lines until one satisfies `wanted`; nothing when none does before the end or within `patience`.
    std::optional<std::string> wait_for(const std::function<bool(const std::string&)>& wanted,
                                        std::chrono::seconds patience);

    /// All lines read so far.
    const std::vector<std::string>& lines() const { return lines_; }

    pid_t process_id() const { return process_; }

    /// Direct children now running whose command line holds `part`.
    std::vector<pid_t> children_with(const std::string& part) const;

    void send(int signal) const;

    /// Reads the rest of the output and waits; the exit code, or 128 + the signal that ended it.
    int wait();

  private:
    pid_t process_ = -1;
    int output_ = -1;
    std::string pending_;
    std::vector<std::string> lines_;
};

}  // namespace deixis
