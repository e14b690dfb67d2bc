// Reads TOML into a settings table and prints the table as a commented TOML file.
#include "appliance/station/settings_table.h"

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <type_traits>

namespace deixis {
namespace {

constexpr int64_t largest_int = std::numeric_limits<int>::max();

std::string shown(const toml::node& node) {
    std::ostringstream text;
    node.visit([&](const auto& value) {
        if constexpr (toml::is_table<decltype(value)>)
            text << "a table";
        else if constexpr (toml::is_array<decltype(value)>)
            text << "an array";
        else
            text << value;
    });
    std::string s = text.str();
    if (s.size() > 60) s = s.substr(0, 57) + "...";
    return s;
}

/// Stores the node; false when its type or size does not fit.
bool store(const toml::node& node, bool* target) {
    if (!node.is_boolean()) return false;
    *target = node.as_boolean()->get();
    return true;
}
bool store(const toml::node& node, int64_t* target) {
    if (!node.is_integer()) return false;
    *target = node.as_integer()->get();
    return true;
}
bool store(const toml::node& node, int* target) {
    if (!node.is_integer()) return false;
    const int64_t value = node.as_integer()->get();
    if (value > largest_int || value < -largest_int) return false;
    *target = static_cast<int>(value);
    return true;
}
bool store(const toml::node& node, double* target) {
    if (!node.is_number()) return false;
    const double value = *node.value<double>();
    if (!std::isfinite(value)) return false;
    *target = value;
    return true;
}
bool store(const toml::node& node, std::string* target) {
    if (!node.is_string()) return false;
    *target = node.as_string()->get();
    return true;
}
bool store(const toml::node& node, std::vector<std::string>* target) {
    if (!node.is_array()) return false;
    std::vector<std::string> values;
    for (const toml::node& item : *node.as_array()) {
        if (!item.is_string()) return false;
        values.push_back(item.as_string()->get());
    }
    *target = std::move(values);
    return true;
}

const char* expected_type(const SettingTarget& target) {
    static constexpr const char* names[] = {"true or false",   "a whole number", "a whole number",
                                            "a finite number", "a text",         "an array of texts"};
    return names[target.index()];
}

std::string ignored(const std::string& file, const std::string& what) {
    return one_line(file + ": unknown " + what + " is ignored");
}

Result<void> apply_section(const SettingSection& section, const toml::table& values, const std::string& file,
                           std::vector<std::string>& warnings) {
    for (const auto& [key, node] : values) {
        const std::string name(key.str());
        const auto field = std::find_if(section.fields.begin(), section.fields.end(),
                                        [&](const SettingField& f) { return f.key == name; });
        if (field == section.fields.end()) {
            warnings.push_back(ignored(file, "key " + section.name + "." + name));
            continue;
        }
        const toml::node& value = node;
        if (!std::visit([&](auto* target) { return store(value, target); }, field->target))
            return fail(file + ": " + section.name + "." + field->key + " is " + shown(value) +
                        ", expected " + expected_type(field->target));
    }
    return {};
}

std::string toml_text(const SettingTarget& target) {
    std::ostringstream text;
    text.precision(15);
    std::visit(
        [&](auto* value) {
            using T = std::remove_pointer_t<decltype(value)>;
            if constexpr (std::is_same_v<T, bool>) {
                text << (*value ? "true" : "false");
            } else if constexpr (std::is_same_v<T, std::string>) {
                text << toml::value<std::string>(*value);
            } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
                text << '[';
                for (size_t i = 0; i < value->size(); ++i)
                    text << (i ? ", " : "") << toml::value<std::string>((*value)[i]);
                text << ']';
            } else {
                text << *value;
                if (std::is_same_v<T, double> && text.str().find_first_of(".e") == std::string::npos)
                    text << ".0";
            }
        },
        target);
    return text.str();
}

}  // namespace

Result<void> apply_settings(const SettingsTable& table, std::string_view text, const std::string& file,
                            std::vector<std::string>& warnings) {
    toml::table root;
    try {
        root = toml::parse(text);
    } catch (const toml::parse_error& error) {
        return fail(file + ": line " + std::to_string(error.source().begin.line) +
                    " is not TOML: " + std::string(error.description()));
    }
    for (const auto& [key, node] : root) {
        const std::string name(key.str());
        const auto section =
            std::find_if(table.begin(), table.end(), [&](const SettingSection& s) { return s.name == name; });
        if (section == table.end()) {
            warnings.push_back(ignored(file, "section " + name));
            continue;
        }
        if (!node.is_table())
            return fail(file + ": " + section->name + " is " + shown(node) + ", expected a section [" +
                        section->name + "]");
        if (auto applied = apply_section(*section, *node.as_table(), file, warnings); !applied)
            return applied;
    }
    for (const SettingSection& section : table) {
        const InvalidSettings complaints = section.validate();
        if (complaints.empty()) continue;
        const InvalidSetting& c = complaints.front();
        return fail(file + ": " + section.name + "." + c.key + " is " + c.value + ", allowed is " + c.range);
    }
    return {};
}

std::string describe_settings(const SettingsTable& table) {
    std::string text;
    for (const SettingSection& section : table) {
        text += "\n[" + section.name + "]\n";
        for (const SettingField& field : section.fields)
            text += "# " + field.key + " = " + toml_text(field.target) + "\n";
    }
    return text;
}

}  // namespace deixis
