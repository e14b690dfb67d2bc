// expected.toml: reading and checking.
#include "appliance/acceptance/expected_file.h"

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cmath>

namespace deixis {

namespace {

struct Criterion {
    const char* key;
    std::optional<double> Expected::*value;
    bool share;
};

constexpr std::array<Criterion, 10> criteria = {
    {{"marks_found_min", &Expected::marks_found_min, true},
     {"false_marks_max", &Expected::false_marks_max, false},
     {"position_mm_median_max", &Expected::position_mm_median_max, false},
     {"position_mm_p95_max", &Expected::position_mm_p95_max, false},
     {"joint_error_mm_max", &Expected::joint_error_mm_max, false},
     {"pcp_min", &Expected::pcp_min, true},
     {"part_mm_max", &Expected::part_mm_max, false},
     {"part_deg_max", &Expected::part_deg_max, false},
     {"frame_ms_p99_max", &Expected::frame_ms_p99_max, false},
     {"tolerance_mm", &Expected::tolerance_mm, false}}};

}  // namespace

Result<Expected> read_expected(const std::filesystem::path& path) {
    toml::table table;
    try {
        table = toml::parse_file(path.string());
    } catch (const toml::parse_error& error) {
        const auto line = error.source().begin.line;
        const std::string place = line == 0 ? "" : " line " + std::to_string(line);
        return fail(path.string() + place + ": " + std::string(error.description()));
    }
    Expected expected;
    for (const auto& [key, node] : table) {
        const auto criterion = std::find_if(criteria.begin(), criteria.end(),
                                            [&](const Criterion& known) { return key.str() == known.key; });
        const std::string place = path.string() + ": " + std::string(key.str());
        if (criterion == criteria.end()) {
            expected.warnings.push_back(one_line(path.string() + ": unknown key " + std::string(key.str())));
            continue;
        }
        const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
        const double highest = criterion->share ? 1.0 : 1e12;
        if (!value || !(*value >= 0 && *value <= highest)) {
            return fail(place + (criterion->share ? " must be a share from 0 to 1"
                                                  : " must be a number of 0 or more"));
        }
        expected.*(criterion->value) = value;
    }
    return expected;
}

}  // namespace deixis
