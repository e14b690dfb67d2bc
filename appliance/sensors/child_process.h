// A child of this process: started, watched through its door bell, ended. No shell, no inherited files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

struct ChildCommand {
    std::filesystem::path program;
    std::vector<std::string> arguments;                            ///< without the program
    std::vector<std::pair<std::string, std::string>> environment;  ///< set on top of ours
};

/// The child gets SIGHUP when the thread that started it ends, ignores SIGINT (a Ctrl-C is for the station,
/// which then ends its children in order), keeps standard input, output and error, and has file 3 to ring the
/// door bell: any byte written there wakes `wait_for_bell`. All other files are closed to it.
class ChildProcess {
  public:
    /// Refuses, naming the program, one that is not an executable file, and what the system refuses.
    static Result<ChildProcess> start(const ChildCommand& command);
    ChildProcess(ChildProcess&& other) noexcept;
    ChildProcess& operator=(ChildProcess&& other) noexcept;
    ~ChildProcess();  ///< kills and reaps

    int process_id() const { return pid_; }
    int bell() const { return bell_; }  ///< file to poll for POLLIN
    void hush();                        ///< empties the bell

    /// Once the child has ended: "ended with code 1", "was killed by signal 9 (Killed)". Reaps it.
    const std::optional<std::string>& ended();

    bool has_ended() const { return end_.has_value(); }  ///< as far as `ended` has found

    void ask_to_end();  ///< SIGTERM
    void kill();        ///< SIGKILL and reaps

  private:
    ChildProcess() = default;
    int pid_ = 0;
    int bell_ = -1;
    std::optional<std::string> end_;
};

}  // namespace deixis
