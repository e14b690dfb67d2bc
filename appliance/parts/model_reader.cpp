// The parent's end of the model reader: starts the child, takes its reply in time, believes nothing
// unchecked.
#include "appliance/parts/model_reader.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "appliance/parts/model_file.h"
#include "appliance/parts/model_reader_child.h"

namespace deixis {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int reply_file_in_child = 3;
constexpr size_t longest_sentence = 10'000;

class File {
  public:
    explicit File(int number) : number_(number) {}
    ~File() { reset(); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    int number() const { return number_; }
    void reset() {
        if (number_ >= 0) close(number_);
        number_ = -1;
    }

  private:
    int number_;
};

/// Enough digits to give back the same bits.
std::string exact_text(double value) {
    char text[64];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

std::vector<std::string> arguments_of(const ModelReader& reader, const ModelRequest& request) {
    return {reader.program.string(),
            "model-reader",
            "--model=" + request.model.string(),
            "--metres-per-unit=" + exact_text(request.metres_per_unit),
            "--time-limit=" + exact_text(request.limits.time_limit_s),
            "--memory-limit=" + std::to_string(request.limits.memory_limit_mb),
            "--reply=" + std::to_string(request.reply_file)};
}

/// Starts the child with `reply` as file 3, silent, with every other file closed and default signals.
/// Returns 0 or the system's error.
int spawn(std::vector<std::string> arguments, int reply, pid_t& pid) {
    std::vector<char*> pointers;
    pointers.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, reply, reply_file_in_child);
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        posix_spawn_file_actions_addopen(&files, standard, "/dev/null", O_RDWR, 0);
    posix_spawn_file_actions_addclosefrom_np(&files, reply_file_in_child + 1);
    const int error = posix_spawn(&pid, pointers[0], &files, &attributes, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    return error;
}

/// Kills what still runs and says how the child ended: nullopt for code 0. A child that had already closed
/// its end of the pipe by ending keeps its own status.
std::optional<std::string> end_of(pid_t pid) {
    kill(pid, SIGKILL);
    int status = 0;
    pid_t answer = 0;
    // A process that hangs in the file system cannot be reaped yet, and nobody waits for it.
    for (int i = 0; i < 2000 && (answer = waitpid(pid, &status, WNOHANG)) == 0; ++i) usleep(1000);
    if (answer != pid) return "did not end";
    if (WIFSIGNALED(status))
        return "crashed on it (signal " + std::to_string(WTERMSIG(status)) + ", " +
               strsignal(WTERMSIG(status)) + ")";
    if (WEXITSTATUS(status) != 0) return "gave up on it (code " + std::to_string(WEXITSTATUS(status)) + ")";
    return std::nullopt;
}

enum class Reply { whole, cut, late, nonsense };

/// Reads exactly `size` bytes before the deadline; `cut` when the pipe ends before.
Reply take(int pipe, void* into, size_t size, Clock::time_point deadline) {
    char* next = static_cast<char*>(into);
    while (size > 0) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
        if (left <= 0) return Reply::late;
        pollfd waiting = {pipe, POLLIN, 0};
        const int ready = poll(&waiting, 1, static_cast<int>(std::min<int64_t>(left, 60'000)));
        if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
        const ssize_t bytes = ready < 0 ? -1 : read(pipe, next, size);
        if (bytes < 0 && errno == EINTR) continue;
        if (bytes <= 0) return Reply::cut;
        next += bytes;
        size -= static_cast<size_t>(bytes);
    }
    return Reply::whole;
}

/// Nothing may follow a reply.
Reply take_end(int pipe, Clock::time_point deadline) {
    char more = 0;
    const Reply reply = take(pipe, &more, 1, deadline);
    return reply == Reply::cut ? Reply::whole : reply == Reply::late ? Reply::late : Reply::nonsense;
}

Reply take_reply(int pipe, Clock::time_point deadline, SurfaceMesh& mesh, std::string& sentence) {
    ModelReplyHead head;
    if (const Reply taken = take(pipe, &head, sizeof head, deadline); taken != Reply::whole) return taken;
    if (head.mark != ModelReplyHead::right_mark || head.sentence > longest_sentence ||
        head.vertices > most_vertices || head.triangles > most_triangles)
        return Reply::nonsense;
    sentence.resize(head.sentence);
    mesh.vertices.resize(head.vertices);
    mesh.triangles.resize(head.triangles);
    for (const auto& [into, size] :
         {std::pair<void*, size_t>{sentence.data(), sentence.size()},
          {mesh.vertices.data(), mesh.vertices.size() * sizeof mesh.vertices[0]},
          {mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]}})
        if (const Reply taken = take(pipe, into, size, deadline); taken != Reply::whole) return taken;
    return take_end(pipe, deadline);
}

std::string seconds_text(double seconds) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g s", seconds);
    return text;
}

}  // namespace

InvalidSettings ModelReaderParams::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "time_limit_s", time_limit_s, 0.001, 3600);
    require_range(complaints, "memory_limit_mb", memory_limit_mb, 1024, 1 << 20);
    return complaints;
}

Result<SurfaceMesh> load_mesh(const std::filesystem::path& model, double metres_per_unit,
                              const ModelReader& reader) {
    const std::string name = model.string(), unreadable = ": cannot be started to read " + name + ": ";
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
        return fail(reader.program.string() + unreadable + std::generic_category().message(errno) + ".");
    const File from_child(ends[0]);
    File to_parent(ends[1]);
    const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                             std::chrono::duration<double>(reader.params.time_limit_s));
    pid_t pid = 0;
    const ModelRequest request = {model, metres_per_unit, reader.params, reply_file_in_child};
    if (const int error = spawn(arguments_of(reader, request), to_parent.number(), pid); error != 0)
        return fail(reader.program.string() + unreadable + std::generic_category().message(error) + ".");
    to_parent.reset();

    SurfaceMesh mesh;
    std::string sentence;
    const Reply reply = take_reply(from_child.number(), deadline, mesh, sentence);
    const auto end = end_of(pid);
    if (reply == Reply::late)
        return fail(name + ": the model reader was not done after " +
                    seconds_text(reader.params.time_limit_s) + "; is the file damaged, or far too fine?");
    if (reply == Reply::nonsense) return fail(name + ": the model reader gave no sensible answer.");
    if (end) return fail(name + ": the model reader " + *end + "; is the file damaged?");
    if (reply == Reply::cut) return fail(name + ": the model reader ended without an answer.");
    if (!sentence.empty()) return fail(std::move(sentence));
    return checked_mesh(std::move(mesh), model);
}

}  // namespace deixis
