// A TOML file being read key by key: each value is checked where it is taken, keys that nobody takes become
// warnings.
#include "appliance/calibration/toml_section.h"

#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

namespace deixis {
namespace {

/// A value as the file has it, not endless.
std::string shown(const toml::node& node) {
    if (node.is_table()) return "a table";
    if (node.is_floating_point()) return toml_float(node.as_floating_point()->get());
    std::ostringstream out;
    out << toml::default_formatter(node.is_array() ? *node.as_array() : toml::array{node});
    std::string text = out.str();
    if (!node.is_array()) text = text.substr(1, text.size() - 2);
    text = one_line(std::move(text));
    const size_t begin = text.find_first_not_of(' ');
    const size_t end = text.find_last_not_of(' ');
    text = begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
    return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

/// A finite TOML integer or float.
std::optional<double> finite_number(const toml::node& node) {
    std::optional<double> value;
    if (node.is_integer()) value = static_cast<double>(node.as_integer()->get());
    if (node.is_floating_point()) value = node.as_floating_point()->get();
    return value && std::isfinite(*value) ? value : std::nullopt;
}

bool append_numbers(const toml::node& node, size_t count, std::vector<double>& out) {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->size() != count) return false;
    for (const toml::node& element : *array) {
        const std::optional<double> value = finite_number(element);
        if (!value) return false;
        out.push_back(*value);
    }
    return true;
}

}  // namespace

Result<toml::table> parse_toml(std::string_view text, const std::string& file) {
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& error) {
        return fail(file + ": line " + std::to_string(error.source().begin.line) + ", column " +
                    std::to_string(error.source().begin.column) +
                    ": expected TOML: " + std::string(error.description()));
    }
}

TomlSection::TomlSection(const toml::table& table, std::string place, TomlComplaints& complaints)
    : table_(&table), place_(std::move(place)), complaints_(&complaints) {}

bool TomlSection::has(std::string_view key) const {
    return table_->contains(key);
}

void TomlSection::refuse(std::string_view key, const std::string& expected, const std::string& found) {
    if (complaints_->first) return;
    std::string sentence =
        complaints_->file + ": key '" + place_ + std::string(key) + "': expected " + expected;
    if (!found.empty()) sentence += ", found " + found;
    complaints_->first = Failure{one_line(std::move(sentence))};
}

const toml::node* TomlSection::take(std::string_view key, const char* expected, bool required) {
    taken_.emplace(key);
    const toml::node* node = table_->get(key);
    if (node == nullptr && required) refuse(key, expected, "nothing");
    return node;
}

std::vector<std::string> TomlSection::keys() const {
    std::vector<std::string> keys;
    for (const auto& [key, node] : *table_) keys.emplace_back(key.str());
    return keys;
}

void TomlSection::ignore(std::string_view key) {
    taken_.emplace(key);
}

std::string TomlSection::text(std::string_view key, const char* expected) {
    const toml::node* node = take(key, expected, true);
    if (node == nullptr) return "";
    if (const auto* value = node->as_string()) return value->get();
    refuse(key, expected, shown(*node));
    return "";
}

std::optional<std::string> TomlSection::optional_text(std::string_view key, const char* expected) {
    if (has(key)) return text(key, expected);
    ignore(key);
    return std::nullopt;
}

int64_t TomlSection::whole_number(std::string_view key, int64_t low, int64_t high) {
    const std::string expected = "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
    const toml::node* node = take(key, expected.c_str(), true);
    if (node == nullptr) return low;
    const auto* value = node->as_integer();
    if (value != nullptr && value->get() >= low && value->get() <= high) return value->get();
    refuse(key, expected, shown(*node));
    return low;
}

double TomlSection::number(std::string_view key, double low, double high, const char* expected) {
    const toml::node* node = take(key, expected, true);
    if (node == nullptr) return low;
    const std::optional<double> value = finite_number(*node);
    if (value && *value >= low && *value <= high) return *value;
    refuse(key, expected, shown(*node));
    return low;
}

std::vector<double> TomlSection::numbers(std::string_view key, size_t count, const char* expected) {
    std::vector<double> values;
    const toml::node* node = take(key, expected, true);
    if (node != nullptr && append_numbers(*node, count, values)) return values;
    if (node != nullptr) refuse(key, expected, shown(*node));
    return std::vector<double>(count, 0.0);
}

std::vector<double> TomlSection::matrix3(std::string_view key, const char* expected) {
    std::vector<double> values;
    const toml::node* node = take(key, expected, true);
    const toml::array* rows = node == nullptr ? nullptr : node->as_array();
    if (rows != nullptr && rows->size() == 3 && append_numbers((*rows)[0], 3, values) &&
        append_numbers((*rows)[1], 3, values) && append_numbers((*rows)[2], 3, values))
        return values;
    if (node != nullptr) refuse(key, expected, shown(*node));
    return std::vector<double>(9, 0.0);
}

std::vector<TomlSection> TomlSection::tables(std::string_view key) {
    std::vector<TomlSection> sections;
    const std::string expected = "tables headed [[" + std::string(key) + "]]";
    const toml::node* node = take(key, expected.c_str(), false);
    if (node == nullptr) return sections;
    const toml::array* array = node->as_array();
    if (array == nullptr || !array->is_array_of_tables()) {
        refuse(key, expected, shown(*node));
        return sections;
    }
    for (const toml::node& element : *array)
        sections.emplace_back(*element.as_table(),
                              place_ + std::string(key) + "[" + std::to_string(sections.size()) + "].",
                              *complaints_);
    return sections;
}

std::optional<TomlSection> TomlSection::table(std::string_view key) {
    const toml::node* node = take(key, "a table", false);
    if (node == nullptr) return std::nullopt;
    if (const toml::table* table = node->as_table())
        return TomlSection(*table, place_ + std::string(key) + ".", *complaints_);
    refuse(key, "a table headed [" + std::string(key) + "]", shown(*node));
    return std::nullopt;
}

std::string TomlSection::utc_time(std::string_view key) {
    const char* expected = "a time like \"2026-11-22T10:00:00Z\"";
    const toml::node* node = take(key, expected, true);
    if (node == nullptr) return "";
    std::string text;
    if (const auto* value = node->as_string()) text = value->get();
    if (node->is_date_time()) text = shown(*node);
    if (is_utc_time(text)) return text;
    refuse(key, expected, shown(*node));
    return "";
}

void TomlSection::warn_of_unknown_keys() {
    for (const auto& [key, node] : *table_)
        if (!taken_.contains(key.str()))
            complaints_->warnings.push_back(one_line(complaints_->file + ": unknown key '" + place_ +
                                                     std::string(key.str()) + "' is ignored"));
}

bool is_utc_time(std::string_view text) {
    constexpr std::string_view pattern = "0000-00-00T00:00:00";
    if (text.size() < pattern.size() + 1 || text.back() != 'Z') return false;
    for (size_t i = 0; i < pattern.size(); ++i) {
        const bool digit = text[i] >= '0' && text[i] <= '9';
        if (pattern[i] == '0' ? !digit : text[i] != pattern[i]) return false;
    }
    const auto pair = [&](size_t at) { return (text[at] - '0') * 10 + (text[at + 1] - '0'); };
    const int month = pair(5);
    const int day = pair(8);
    if (month < 1 || month > 12 || day < 1 || day > 31) return false;
    if (pair(11) > 23 || pair(14) > 59 || pair(17) > 60) return false;
    const std::string_view fraction = text.substr(pattern.size(), text.size() - pattern.size() - 1);
    if (fraction.empty()) return true;
    return fraction.size() >= 2 && fraction.size() <= 10 && fraction[0] == '.' &&
           fraction.find_first_not_of("0123456789", 1) == std::string_view::npos;
}

std::string toml_quoted(std::string_view text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (byte < 0x20 || byte == 0x7f) {
            constexpr const char* digits = "0123456789ABCDEF";
            out += "\\u00";
            out += digits[byte >> 4];
            out += digits[byte & 15];
        } else {
            out += c;
        }
    }
    return out + "\"";
}

std::string toml_float(double value) {
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value < 0 ? "-inf" : "inf";
    std::array<char, 40> text = {};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    std::string out(text.data(), end);
    if (out.find_first_of(".e") == std::string::npos) out += ".0";
    return out;
}

}  // namespace deixis
