// Settings as a table of fields: sections of named values that a TOML file may overwrite, each checked by its
// stage.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tracking/geometry/result.h"

namespace deixis {

/// A field of some `Params`, by address; the table never outlives it.
using SettingTarget = std::variant<bool*, int*, int64_t*, double*, std::string*, std::vector<std::string>*>;

struct SettingField {
    std::string key;
    SettingTarget target;
};

struct SettingSection {
    std::string name;
    std::vector<SettingField> fields;
    std::function<InvalidSettings()> validate;
};

using SettingsTable = std::vector<SettingSection>;

/// Overwrites the fields of `table` with what the TOML `text` holds and lets each section check itself.
/// `file` only names the source in sentences. Refuses broken TOML (with its line), a section that is no
/// table, a value of another type (an integer is taken for a double, nothing else is converted), and values
/// out of range, naming file, key, value and range. An unknown section or key is a warning. On refusal the
/// fields may be half overwritten.
Result<void> apply_settings(const SettingsTable& table, std::string_view text, const std::string& file,
                            std::vector<std::string>& warnings);

/// The table as a TOML file in which every default stands commented out.
std::string describe_settings(const SettingsTable& table);

}  // namespace deixis
