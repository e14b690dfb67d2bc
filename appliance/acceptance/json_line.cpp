// JSON Lines, one checked key at a time.
#include "appliance/acceptance/json_line.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace deixis {

namespace {

constexpr size_t longest_line = 1'000'000;

std::string shown(const nlohmann::json& value) {
    std::string text = value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    if (text.size() > 40) text = text.substr(0, 40) + "...";
    return text;
}

bool finite_triple(const nlohmann::json& value, Eigen::Vector3d& out) {
    if (!value.is_array() || value.size() != 3) return false;
    for (int i = 0; i < 3; ++i) {
        const nlohmann::json& number = value[static_cast<size_t>(i)];
        if (!number.is_number()) return false;
        out[i] = number.get<double>();
        if (!std::isfinite(out[i])) return false;
    }
    return true;
}

}  // namespace

JsonObject::JsonObject(const nlohmann::json& object, std::string place, std::string prefix)
    : object_(&object), place_(std::move(place)), prefix_(std::move(prefix)) {}

void JsonObject::refuse(const std::string& what) const {
    throw RefusedLine{place_ + ": " + what};
}

void JsonObject::refuse_type(const char* key, const char* expected, const nlohmann::json& value) const {
    refuse(prefix_ + key + " is " + shown(value) + ", expected " + expected);
}

const nlohmann::json* JsonObject::find(const char* key) const {
    const auto found = object_->find(key);
    return found == object_->end() || found->is_null() ? nullptr : &*found;
}

std::optional<int64_t> JsonObject::integer(const char* key) const {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return std::nullopt;
    const bool too_large = value->is_number_unsigned() && value->get<uint64_t>() > uint64_t{INT64_MAX};
    if (!value->is_number_integer() || too_large) refuse_type(key, "a whole number of 64 bit", *value);
    return value->get<int64_t>();
}

std::optional<double> JsonObject::number(const char* key) const {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_number() || !std::isfinite(value->get<double>()))
        refuse_type(key, "a finite number", *value);
    return value->get<double>();
}

std::optional<bool> JsonObject::boolean(const char* key) const {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_boolean()) refuse_type(key, "true or false", *value);
    return value->get<bool>();
}

std::optional<std::string> JsonObject::text(const char* key) const {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_string()) refuse_type(key, "a text", *value);
    return value->get<std::string>();
}

std::optional<Eigen::Vector3d> JsonObject::vector(const char* key) const {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return std::nullopt;
    Eigen::Vector3d vector;
    if (!finite_triple(*value, vector)) refuse_type(key, "three finite numbers", *value);
    return vector;
}

std::optional<Eigen::Matrix3d> JsonObject::rotation(const char* key) const {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return std::nullopt;
    Eigen::Matrix3d rotation;
    bool good = value->is_array() && value->size() == 3;
    for (int row = 0; good && row < 3; ++row) {
        Eigen::Vector3d numbers;
        good = finite_triple((*value)[static_cast<size_t>(row)], numbers);
        if (good) rotation.row(row) = numbers;
    }
    if (!good) refuse_type(key, "3 rows of 3 finite numbers", *value);
    const double skew = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!(skew <= 1e-4) || rotation.determinant() < 0) {
        refuse_type(key, "a rotation, orthonormal to 1e-4 and no reflection", *value);
    }
    return rotation;
}

std::optional<ArmSide> JsonObject::arm(const char* key) const {
    const std::optional<std::string> side = text(key);
    if (!side) return std::nullopt;
    if (*side == "left") return ArmSide::left;
    if (*side == "right") return ArmSide::right;
    refuse_type(key, "\"left\" or \"right\"", *side);
}

std::optional<JsonObject> JsonObject::object(const char* key) const {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_object()) refuse_type(key, "an object", *value);
    return JsonObject(*value, place_, prefix_ + key + ".");
}

std::optional<std::vector<JsonObject>> JsonObject::objects(const char* key) const {
    const nlohmann::json* value = find(key);
    if (value == nullptr) return std::nullopt;
    if (!value->is_array()) refuse_type(key, "an array of objects", *value);
    std::vector<JsonObject> inner;
    for (const nlohmann::json& element : *value) {
        if (!element.is_object()) refuse_type(key, "an array of objects", *value);
        inner.emplace_back(element, place_, prefix_ + key + "[" + std::to_string(inner.size()) + "].");
    }
    return inner;
}

std::vector<std::string> JsonObject::keys() const {
    std::vector<std::string> names;
    for (const auto& [key, value] : object_->items()) names.push_back(key);
    return names;
}

void JsonObject::warn_unknown(std::initializer_list<std::string_view> known, std::set<std::string>& seen,
                              std::vector<std::string>& warnings) const {
    warn_unknown(std::span(known.begin(), known.size()), seen, warnings);
}

void JsonObject::warn_unknown(std::span<const std::string_view> known, std::set<std::string>& seen,
                              std::vector<std::string>& warnings) const {
    for (const std::string& key : keys()) {
        if (std::find(known.begin(), known.end(), key) != known.end()) continue;
        if (seen.insert(prefix_ + key).second)
            warnings.push_back(one_line(place_ + ": unknown key " + prefix_ + key));
    }
}

bool next_json_line(std::istream& in, const std::string& name, size_t& line_number, nlohmann::json& line) {
    std::string text;
    while (std::getline(in, text)) {
        ++line_number;
        if (text.find_first_not_of(" \t\r") == std::string::npos) continue;
        const std::string place = name + " line " + std::to_string(line_number);
        if (text.size() > longest_line) throw RefusedLine{place + ": longer than 1 MB"};
        line = nlohmann::json::parse(text, nullptr, false);
        if (line.is_discarded()) throw RefusedLine{place + ": not JSON"};
        if (!line.is_object()) throw RefusedLine{place + ": expected a JSON object"};
        return true;
    }
    return false;
}

}  // namespace deixis
