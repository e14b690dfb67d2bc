// RFC 4180 with cells that no spreadsheet takes for a formula.
#include "appliance/exports/defect_csv.h"

#include <array>
#include <charconv>
#include <string_view>

namespace deixis {
namespace {

constexpr std::string_view line_end = "\r\n";
constexpr std::string_view replacement = "\xEF\xBF\xBD";

bool looks_like_formula(std::string_view text) {
    constexpr std::array<std::string_view, 10> beginnings{
        "=", "+", "-", "@", "\t", "\r", "\xEF\xBC\x9D", "\xEF\xBC\x8B", "\xEF\xBC\x8D", "\xEF\xBC\xA0"};
    for (const std::string_view beginning : beginnings)
        if (text.starts_with(beginning)) return true;
    return false;
}

std::string cell(const std::string& raw) {
    std::string text;
    for (const char c : valid_utf8(raw)) {
        if (c == '\0')
            text += replacement;
        else
            text += c;
    }
    if (looks_like_formula(text)) text.insert(0, 1, '\'');
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"') quoted += '"';
        quoted += c;
    }
    return quoted + '"';
}

/// Independent of the locale; "-0.000" is written without its sign.
std::string decimal(double value, int decimals) {
    std::array<char, 400> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                   std::chars_format::fixed, decimals);
    std::string text(buffer.data(), end.ptr);
    if (text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
    return text;
}

struct CellWriter {
    std::string operator()(int64_t value) const { return std::to_string(value); }
    std::string operator()(double value) const { return decimal(value, 6); }
    std::string operator()(Millimetres value) const { return decimal(value.value, 3); }
    std::string operator()(bool value) const { return value ? "true" : "false"; }
    std::string operator()(const std::string& value) const { return cell(value); }
};

}  // namespace

std::string defect_csv(const std::vector<DefectRecord>& records, const QualityCodes& codes) {
    std::string csv;
    for (const DefectField& field : defect_fields({}, 1, codes)) {
        if (!csv.empty()) csv += ',';
        csv += field.name;
    }
    csv += line_end;
    const std::vector<int64_t> numbers = position_numbers(records);
    for (size_t i = 0; i < records.size(); ++i) {
        bool first = true;
        for (const DefectField& field : defect_fields(records[i], numbers[i], codes)) {
            if (!first) csv += ',';
            first = false;
            csv += std::visit(CellWriter{}, field.value);
        }
        csv += line_end;
    }
    return csv;
}

}  // namespace deixis
