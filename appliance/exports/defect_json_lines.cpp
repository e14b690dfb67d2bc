// The fields as JSON values, rounded as the CSV rounds them.
#include "appliance/exports/defect_json_lines.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace deixis {
namespace {

double rounded(double value, double steps) {
    const double result = std::round(value * steps) / steps;
    return result == 0 ? 0.0 : result;  // not -0
}

struct JsonValue {
    nlohmann::ordered_json operator()(int64_t value) const { return value; }
    nlohmann::ordered_json operator()(double value) const { return rounded(value, 1e6); }
    nlohmann::ordered_json operator()(Millimetres value) const { return rounded(value.value, 1e3); }
    nlohmann::ordered_json operator()(bool value) const { return value; }
    nlohmann::ordered_json operator()(const std::string& value) const { return valid_utf8(value); }
};

}  // namespace

std::string defect_json_lines(const std::vector<DefectRecord>& records, const QualityCodes& codes) {
    std::string lines;
    const std::vector<int64_t> numbers = position_numbers(records);
    for (size_t i = 0; i < records.size(); ++i) {
        nlohmann::ordered_json object;
        for (const DefectField& field : defect_fields(records[i], numbers[i], codes))
            object[field.name] = std::visit(JsonValue{}, field.value);
        lines += object.dump() + "\n";
    }
    return lines;
}

}  // namespace deixis
