// JSON lines: every line obeys the published schema and says what the CSV says.
#include "appliance/exports/defect_json_lines.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/appliance/exports/export_samples.h"

namespace deixis {
namespace {

using nlohmann::json;

json schema() {
    return json::parse(std::ifstream(DEFECT_SCHEMA));
}

std::vector<json> lines_of(const std::string& text) {
    std::vector<json> lines;
    for (size_t at = 0, end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
        lines.push_back(json::parse(text.substr(at, end - at)));
    return lines;
}

bool has_type(const json& value, const std::string& type) {
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    if (type == "boolean") return value.is_boolean();
    return type == "string" && value.is_string();
}

/// The part of JSON Schema that our schema uses, for one value.
bool obeys(const json& value, const json& rule) {
    const auto text = [&] { return value.get<std::string>(); };
    const auto holds = [&](const char* keyword, const auto& condition) {
        return !rule.contains(keyword) || condition(rule[keyword]);
    };
    return holds("type", [&](const json& type) { return has_type(value, type); }) &&
           holds("enum",
                 [&](const json& all) { return std::find(all.begin(), all.end(), value) != all.end(); }) &&
           holds("minimum", [&](const json& least) { return value >= least; }) &&
           holds("maximum", [&](const json& most) { return value <= most; }) &&
           holds("minLength", [&](const json& least) { return text().size() >= least.get<size_t>(); }) &&
           holds("maxLength", [&](const json& most) { return text().size() <= most.get<size_t>(); }) &&
           holds("pattern", [&](const json& pattern) {
               return std::regex_search(text(), std::regex(pattern.get<std::string>()));
           });
}

void expect_obeys(const json& object, const json& rules) {
    for (const auto& name : rules["required"]) EXPECT_TRUE(object.contains(name.get<std::string>())) << name;
    for (const auto& [name, value] : object.items()) {
        ASSERT_TRUE(rules["properties"].contains(name)) << name << " is not in the schema";
        EXPECT_TRUE(obeys(value, rules["properties"][name])) << name << " " << value;
    }
}

TEST(DefectJsonLines, ObeysItsSchema) {
    std::vector<DefectRecord> records{plain_record(1), plain_record(2)};
    records[1].delivered_us = 5;
    records[1].state = DefectState::withdrawn;
    records[1].mark.arm = ArmSide::right;
    for (const std::string& text : ugly_texts()) {
        DefectRecord record = plain_record(3);
        record.zone = record.part_serial = record.part_type = text;
        records.push_back(record);
    }
    const auto lines = lines_of(defect_json_lines(records));
    ASSERT_EQ(lines.size(), records.size());
    const json rules = schema();
    for (size_t i = 0; i < lines.size(); ++i) {
        expect_obeys(lines[i], rules);
        EXPECT_EQ(lines[i]["zone"], valid_utf8(records[i].zone));
    }
}

TEST(DefectJsonLines, SchemaAndFieldsNameTheSameThings) {
    const json rules = schema();
    std::vector<std::string> required = rules["required"], named;
    for (const DefectField& field : defect_fields(plain_record(), 1, {})) named.push_back(field.name);
    EXPECT_EQ(required, named);
    EXPECT_EQ(rules["properties"].size(), named.size());
}

TEST(DefectJsonLines, WritesOneObjectALine) {
    EXPECT_EQ(defect_json_lines({}), "");
    EXPECT_EQ(
        defect_json_lines({plain_record()}),
        "{\"id\":1,\"time\":\"2000-02-29T12:34:56.000001Z\",\"part_type\":\"bumper-front-a\",\"part_serial\":"
        "\"0001\",\"x_mm\":310.0,\"y_mm\":-20.5,\"z_mm\":120.0,\"normal_x\":0.0,\"normal_y\":-1.0,\"normal_"
        "z\":"
        "0.0,\"zone\":\"upper left\",\"arm\":\"left\",\"confidence\":0.875,\"touch\":true,\"state\":\"open\","
        "\"source\":\"live\",\"session_us\":33333,\"plc_time\":\"\",\"POSNR\":1,\"FEKAT\":\"9\",\"FEGRP\":"
        "\"PAINT\",\"FECOD\":\"MARK\",\"ANZFEHLER\":1}\n");
}

}  // namespace
}  // namespace deixis
