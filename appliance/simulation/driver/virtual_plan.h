// Which virtual sensors there are and how each behaves: read from a control file or a session folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

/// `silent`: stays open, sends nothing. `small`: sends half the resolution. `garbage`: sends the value 65535.
/// `backwards`: its clock runs backwards. `stuck`: opening it never returns.
enum class VirtualBehaviour { running, unplugged, silent, small, garbage, backwards, stuck };

struct VirtualSensor {
    std::string name;                 ///< its URI is "virtual://<name>"
    std::filesystem::path recording;  ///< .oni file whose frames it sends, over and over
    VirtualBehaviour behaviour = VirtualBehaviour::running;
    int64_t start_us = 0;         ///< added to the stamps of the recording
    int64_t period_us = 0;        ///< from one round to the next; common to sensors that shall stay in step
    int64_t clock_offset_us = 0;  ///< sensor clock minus host clock
};

/// `source` is a session folder (its depth streams), or a control file, one table a sensor:
///
///     [left]
///     recording = "left.oni"    # relative to the control file
///     state = "running"         # running unplugged silent small garbage backwards stuck
///     start_us = 0
///     clock_offset_us = 0
///     period_us = 2000000       # default: the longest recording and 1/30 s
///
/// Refuses, naming file and key: unreadable files, unknown keys and states, recordings that do not walk.
Result<std::vector<VirtualSensor>> read_virtual_plan(const std::filesystem::path& source);

}  // namespace deixis
