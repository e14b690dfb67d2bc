// expected.toml as a value: the acceptance criteria of a session, all optional.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

struct Expected {
    std::optional<double> marks_found_min;  ///< share of the meant holds, 0 to 1
    std::optional<double> false_marks_max;
    std::optional<double> position_mm_median_max;
    std::optional<double> position_mm_p95_max;
    std::optional<double> joint_error_mm_max;
    std::optional<double> pcp_min;  ///< share, 0 to 1
    std::optional<double> part_mm_max;
    std::optional<double> part_deg_max;
    std::optional<double> frame_ms_p99_max;
    std::optional<double> tolerance_mm;
    std::vector<std::string> warnings;  ///< unknown keys, one sentence each
};

/// Reads and checks `path`; refuses what is not TOML (naming the line), a value that is not a finite number,
/// a negative one, and a share above 1, naming file and key.
Result<Expected> read_expected(const std::filesystem::path& path);

}  // namespace deixis
