// Who may include whom, never upwards, and the one home of each heavy library: design.md as a table.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace deixis {

/// One folder of the house. `path` covers its files and those of folders below it that are no rooms of their
/// own.
struct Room {
    std::string path;
    std::vector<std::string> may_include;  ///< other rooms
};

/// Headers of an outside library and the rooms it may be seen in.
struct LibraryHome {
    std::string library;
    std::string header;  ///< regular expression for the whole name between the angle brackets or quotes
    std::vector<std::string> homes;  ///< path prefixes; tests/ may use every library as a peer
    bool hidden = false;             ///< a header of ours that shows it is for its own room only
};

const std::vector<Room>& rooms();
const std::vector<LibraryHome>& library_homes();

/// What `line` includes, without brackets or quotes; nothing when it is no include line.
std::optional<std::string> included_by(const std::string& line);

/// The hidden library that `header` belongs to; empty when none.
std::string hidden_library_of(const std::string& header);

/// The room that `file` lies in; empty when none.
std::string room_of(const std::string& file);

/// Why `file` (path from the root) must not include `header`; nothing when it may.
std::optional<std::string> objection(const std::string& file, const std::string& header);

}  // namespace deixis
