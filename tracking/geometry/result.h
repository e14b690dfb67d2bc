// Expected failures as values: what a stage returns when the outside world (file, sensor, setting) is at
// fault.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

namespace deixis {

/// One plain sentence for a person, naming the file, key or byte offset and what was expected.
struct Failure {
    std::string sentence;
};

template <class T>
using Result = tl::expected<T, Failure>;

/// What came out of a file or a library may hold anything; a sentence is one line: control characters
/// become spaces.
inline std::string one_line(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    return text;
}

inline tl::unexpected<Failure> fail(std::string sentence) {
    return tl::unexpected<Failure>(Failure{one_line(std::move(sentence))});
}

/// A setting outside its range. `key` is the bare field name; the settings reader puts the section before it.
struct InvalidSetting {
    std::string key;
    std::string value;
    std::string range;
};

/// What every `Params::validate()` returns; empty means all is well.
using InvalidSettings = std::vector<InvalidSetting>;

/// Appends a complaint when `value` is not inside [low, high] (NaN never is).
inline void require_range(InvalidSettings& complaints, const char* key, double value, double low,
                          double high) {
    if (value >= low && value <= high) return;
    complaints.push_back({key, std::to_string(value), std::to_string(low) + " to " + std::to_string(high)});
}

}  // namespace deixis
