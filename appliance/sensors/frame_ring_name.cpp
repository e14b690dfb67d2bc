// Names of frame rings: unique to a living process, so that what a killed run left behind can be told and
// removed.
#include <unistd.h>

#include <atomic>
#include <boost/interprocess/shared_memory_object.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <system_error>

#include "appliance/sensors/frame_ring.h"

namespace deixis {
namespace {

constexpr const char* name_prefix = "deixis-ring-";

/// Start time of a process in clock ticks (field 22 of /proc/<pid>/stat); nothing when it does not live.
std::optional<std::string> start_of_process(const std::string& pid) {
    std::ifstream file("/proc/" + pid + "/stat");
    std::string line;
    if (!std::getline(file, line)) return std::nullopt;
    const size_t after_name = line.rfind(')');
    if (after_name == std::string::npos) return std::nullopt;
    std::istringstream fields(line.substr(after_name + 1));
    std::string field;
    for (int i = 3; i <= 22; ++i)
        if (!(fields >> field)) return std::nullopt;
    return field;
}

}  // namespace

std::string unique_ring_name() {
    static std::atomic<uint64_t> number{0};
    const std::string pid = std::to_string(getpid());
    return name_prefix + pid + "-" + start_of_process(pid).value_or("0") + "-" + std::to_string(++number);
}

int remove_left_over_rings() {
    int removed = 0;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/dev/shm", error)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(name_prefix)) continue;
        std::istringstream parts(name.substr(std::strlen(name_prefix)));
        std::string pid, start;
        if (!std::getline(parts, pid, '-') || !std::getline(parts, start, '-')) continue;
        if (pid.empty() || pid.find_first_not_of("0123456789") != std::string::npos) continue;
        if (start_of_process(pid) == start) continue;
        if (boost::interprocess::shared_memory_object::remove(name.c_str())) ++removed;
    }
    return removed;
}

}  // namespace deixis
