// One line of a JSON Lines file: its keys taken out with a check, refused with a sentence that names line and
// key.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <initializer_list>
#include <istream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gestures/mark.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// Thrown by JsonObject, caught by read_json_lines; never leaves a reader.
struct RefusedLine {
    std::string sentence;
};

/// An object within a line. `place` begins every sentence: "truth.jsonl line 3", for an inner object with
/// "key part" added. Every getter takes a missing key and null for "unknown" and throws RefusedLine on a
/// wrong type.
class JsonObject {
  public:
    JsonObject(const nlohmann::json& object, std::string place, std::string prefix);

    std::optional<int64_t> integer(const char* key) const;
    std::optional<double> number(const char* key) const;
    std::optional<bool> boolean(const char* key) const;
    std::optional<std::string> text(const char* key) const;
    std::optional<Eigen::Vector3d> vector(const char* key) const;
    std::optional<Eigen::Matrix3d> rotation(const char* key) const;  ///< orthonormal to 1e-4, no reflection
    std::optional<ArmSide> arm(const char* key) const;
    std::optional<JsonObject> object(const char* key) const;
    std::optional<std::vector<JsonObject>> objects(const char* key) const;
    std::vector<std::string> keys() const;

    /// Adds one sentence for each key not in `known` that `seen` does not hold yet.
    void warn_unknown(std::span<const std::string_view> known, std::set<std::string>& seen,
                      std::vector<std::string>& warnings) const;
    void warn_unknown(std::initializer_list<std::string_view> known, std::set<std::string>& seen,
                      std::vector<std::string>& warnings) const;

    /// Refuses the line: "<place>: <what>".
    [[noreturn]] void refuse(const std::string& what) const;

  private:
    const nlohmann::json* find(const char* key) const;
    [[noreturn]] void refuse_type(const char* key, const char* expected, const nlohmann::json& value) const;

    const nlohmann::json* object_;
    std::string place_;
    std::string prefix_;  ///< "part." within the object of key part
};

/// Calls `take(JsonObject)` for every line that is not blank. Returns the number of lines taken, or the first
/// refusal; refuses a line longer than 1 MB, what is not a JSON object, and a file without a line.
template <class Take>
Result<size_t> read_json_lines(std::istream& in, const std::string& name, Take take);

/// Next line that is not blank, with its number counted from 1; false at the end. Throws RefusedLine.
bool next_json_line(std::istream& in, const std::string& name, size_t& line_number, nlohmann::json& line);

template <class Take>
Result<size_t> read_json_lines(std::istream& in, const std::string& name, Take take) {
    size_t line_number = 0, taken = 0;
    nlohmann::json line;
    try {
        while (next_json_line(in, name, line_number, line)) {
            take(JsonObject(line, name + " line " + std::to_string(line_number), ""));
            ++taken;
        }
    } catch (const RefusedLine& refused) {
        return fail(refused.sentence);
    }
    if (taken == 0) return fail(name + " is empty: expected one JSON object a line");
    return taken;
}

}  // namespace deixis
