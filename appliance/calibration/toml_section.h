// A TOML file being read key by key: each value is checked where it is taken, keys that nobody takes become
// warnings.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

// toml++ is a heavy header: include this one from .cpp files only.
#include <toml++/toml.h>

#include "tracking/geometry/result.h"

namespace deixis {

/// What was wrong with a file: the first failure, and a warning for each unknown key.
struct TomlComplaints {
    std::string file;
    std::optional<Failure> first;
    std::vector<std::string> warnings;
};

/// The table of a whole file, or a failure naming file, line and column.
Result<toml::table> parse_toml(std::string_view text, const std::string& file);

/// One table. Getters never fail: the first thing wrong goes to `complaints` as a sentence naming file and
/// key, and a harmless value comes back. `place` stands before the key in sentences: "" at the top, "cell."
/// or "sensor[0]." below.
class TomlSection {
  public:
    TomlSection(const toml::table& table, std::string place, TomlComplaints& complaints);

    bool has(std::string_view key) const;

    /// A string; required.
    std::string text(std::string_view key, const char* expected);

    /// A string, or nothing where the key is absent.
    std::optional<std::string> optional_text(std::string_view key, const char* expected);

    /// An integer in [low, high]; required.
    int64_t whole_number(std::string_view key, int64_t low, int64_t high);

    /// A finite number (integers count) in [low, high]; required.
    double number(std::string_view key, double low, double high, const char* expected);

    /// An array of exactly `count` finite numbers; required. `count` zeros after a complaint.
    std::vector<double> numbers(std::string_view key, size_t count, const char* expected);

    /// 3 rows of 3 finite numbers, row-major; required.
    std::vector<double> matrix3(std::string_view key, const char* expected);

    /// The tables of `[[key]]`, none where it is absent.
    std::vector<TomlSection> tables(std::string_view key);

    /// The table `[key]`, if there.
    std::optional<TomlSection> table(std::string_view key);

    /// RFC 3339 UTC, as a string or as TOML's own date-time; required.
    std::string utc_time(std::string_view key);

    /// All keys, in the order of the alphabet.
    std::vector<std::string> keys() const;

    /// Takes `key` without looking at it.
    void ignore(std::string_view key);

    /// Puts "file: key 'place.key': expected <expected>, found <found>" first unless something stands there
    /// already.
    void refuse(std::string_view key, const std::string& expected, const std::string& found = "");

    /// One warning for each key that was never taken.
    void warn_of_unknown_keys();

  private:
    const toml::node* take(std::string_view key, const char* expected, bool required);

    const toml::table* table_;
    std::string place_;
    TomlComplaints* complaints_;
    std::set<std::string, std::less<>> taken_;
};

/// "2026-11-22T10:00:00Z", fractions of a second allowed.
bool is_utc_time(std::string_view text);

/// `text` as a TOML basic string, quotes included.
std::string toml_quoted(std::string_view text);

/// The shortest TOML float that reads back as `value`, sign of zero included.
std::string toml_float(double value);

}  // namespace deixis
