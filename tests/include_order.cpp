// The table of rooms and library homes, and its reading.
#include "tests/include_order.h"

#include <algorithm>
#include <regex>

namespace deixis {

namespace {

const Room* find_room(const std::string& path) {
    const Room* found = nullptr;
    for (const Room& room : rooms()) {
        if (path.starts_with(room.path + "/") && (found == nullptr || room.path.size() > found->path.size()))
            found = &room;
    }
    return found;
}

bool is_in(const std::vector<std::string>& prefixes, const std::string& path) {
    return std::any_of(prefixes.begin(), prefixes.end(),
                       [&](const std::string& prefix) { return path.starts_with(prefix); });
}

std::optional<std::string> library_objection(const std::string& file, const std::string& header) {
    if (file.starts_with("tests/")) return std::nullopt;
    for (const LibraryHome& home : library_homes()) {
        if (!std::regex_match(header, std::regex(home.header))) continue;
        if (!is_in(home.homes, file))
            return file + " includes " + header + ": " + home.library + " has its home elsewhere";
    }
    return std::nullopt;
}

}  // namespace

const std::vector<Room>& rooms() {
    static const std::vector<Room> table = {
        {"tracking/geometry", {}},
        {"tracking/volume", {"tracking/geometry"}},
        {"tracking/segments", {"tracking/geometry", "tracking/volume"}},
        {"tracking/part", {"tracking/geometry", "tracking/volume", "tracking/segments"}},
        {"tracking/body", {"tracking/geometry", "tracking/volume", "tracking/segments"}},
        {"gestures", {"tracking/geometry", "tracking/volume", "tracking/body"}},
        {"gestures/handwriting", {"gestures", "tracking/geometry"}},
        {"appliance/calibration", {"tracking"}},
        {"appliance/sessions", {"tracking", "appliance/calibration"}},
        {"appliance/sensors", {"tracking", "appliance/calibration", "appliance/sessions"}},
        {"appliance/parts", {"tracking/geometry", "tracking/part"}},
        {"appliance/simulation",
         {"tracking", "appliance/calibration", "appliance/sessions", "appliance/parts"}},
        {"appliance/records", {"gestures", "tracking/geometry"}},
        {"appliance/plc", {"gestures", "tracking/geometry", "appliance/records"}},
        {"appliance/exports", {"gestures", "tracking/geometry", "appliance/records"}},
        {"appliance/station",
         {"tracking", "gestures", "appliance/calibration", "appliance/sessions", "appliance/sensors",
          "appliance/parts", "appliance/records", "appliance/plc", "appliance/exports"}},
        {"appliance/acceptance",
         {"tracking", "gestures", "appliance/calibration", "appliance/sessions", "appliance/sensors",
          "appliance/parts", "appliance/records", "appliance/plc", "appliance/exports", "appliance/station"}},
        {"hmi/server", {"tracking/geometry"}},
        {"appliance/commands", {"tracking", "gestures", "appliance", "hmi/server"}},
        {"tests", {"tracking", "gestures", "appliance", "hmi/server"}},
    };
    return table;
}

const std::vector<LibraryHome>& library_homes() {
    const std::vector<std::string> edges = {"appliance/", "hmi/server/"};
    static const std::vector<LibraryHome> table = {
        {"PCL", "pcl/.*", {"tracking/part/"}, true},
        {"OpenNI2",
         "(OpenNI|OniC?Api|PS1080|OniVersion|OniCTypes|OniCEnums)\\.h|Driver/.*",
         {"appliance/sensors/", "appliance/simulation/"},
         true},
        {"OpenCV", "opencv2/.*", {"tracking/volume/", "appliance/calibration/", "appliance/sessions/"}, true},
        {"Open CASCADE", ".*\\.hxx", {"appliance/parts/"}, true},
        {"Assimp", "assimp/.*", {"appliance/parts/"}, true},
        {"SQLite", "SQLiteCpp/.*|sqlite3\\.h", {"appliance/records/"}, true},
        {"libmodbus", "modbus(/modbus)?\\.h", {"appliance/plc/"}, true},
        {"Poco", "Poco/.*", {"hmi/server/"}, false},
        {"Embree", "embree3?/.*", {"tracking/geometry/"}, true},
        {"Boost.Interprocess", "boost/.*", {"appliance/sensors/"}, false},
        {"Highway", "hwy/.*", {"tracking/"}, false},
        {"oneTBB", "(oneapi/)?tbb/.*", {"tracking/", "appliance/station/"}, true},
        {"toml++", "toml\\+\\+/.*|toml\\.hpp", {"appliance/"}, false},
        {"CLI11", "CLI/.*", {"appliance/commands/"}, false},
        {"libpng", "png\\.h", {"appliance/sessions/"}, true},
        {"nlohmann-json", "nlohmann/.*", edges, false},
        {"spdlog", "spdlog/.*", edges, false},
        // tracking and gestures are pure: no I/O, no clock, no thread of their own.
        {"file I/O", "fstream|iostream|filesystem|fcntl\\.h|unistd\\.h|sys/.*", edges, false},
        {"the clock", "chrono|ctime|time\\.h", edges, false},
        {"threads", "thread|mutex|shared_mutex|condition_variable|future|semaphore|stop_token", edges, false},
    };
    return table;
}

std::optional<std::string> included_by(const std::string& line) {
    static const std::regex pattern("^\\s*#\\s*include(?:_next)?\\s*[<\"]([^>\"]+)[>\"].*");
    std::smatch match;
    if (!std::regex_match(line, match, pattern)) return std::nullopt;
    return match[1].str();
}

std::string hidden_library_of(const std::string& header) {
    for (const LibraryHome& home : library_homes()) {
        if (home.hidden && std::regex_match(header, std::regex(home.header))) return home.library;
    }
    return "";
}

std::string room_of(const std::string& file) {
    const Room* room = find_room(file);
    return room == nullptr ? "" : room->path;
}

std::optional<std::string> objection(const std::string& file, const std::string& header) {
    const Room* from = find_room(file);
    if (from == nullptr) return file + " lies in no room of the house";
    const bool ours = is_in({"tracking/", "gestures/", "appliance/", "hmi/", "tests/"}, header);
    if (!ours) return library_objection(file, header);
    const Room* to = find_room(header);
    if (to == nullptr) return file + " includes " + header + ", which lies in no room of the house";
    if (to == from) return std::nullopt;
    for (const std::string& allowed : from->may_include) {
        if (to->path == allowed || to->path.starts_with(allowed + "/")) return std::nullopt;
    }
    return file + " includes " + header + ": " + from->path + " may not know " + to->path;
}

}  // namespace deixis
