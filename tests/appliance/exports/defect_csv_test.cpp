// CSV: the columns, one row in full, and ugly texts read back by another program's reader.
#include "appliance/exports/defect_csv.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <clocale>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/appliance/exports/export_samples.h"

namespace deixis {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* header =
    "id,time,part_type,part_serial,x_mm,y_mm,z_mm,normal_x,normal_y,normal_z,zone,arm,confidence,touch,state,"
    "source,"
    "session_us,plc_time,POSNR,FEKAT,FEGRP,FECOD,ANZFEHLER\r\n";

/// The rows as Python's csv module reads them.
std::vector<std::vector<std::string>> read_by_python(const std::string& csv) {
    const auto file = std::filesystem::temp_directory_path() / ("deixis-csv-" + std::to_string(::getpid()));
    std::ofstream(file, std::ios::binary) << csv;
    FILE* python = ::popen(("/usr/bin/python3 " CSV_READER " < " + file.string()).c_str(), "r");
    std::string said;
    char buffer[4096];
    for (size_t got = 0; (got = std::fread(buffer, 1, sizeof buffer, python)) > 0;) said.append(buffer, got);
    EXPECT_EQ(::pclose(python), 0);
    std::filesystem::remove(file);
    std::vector<std::vector<std::string>> rows;
    for (size_t at = 0, end = 0; (end = said.find('\n', at)) != std::string::npos; at = end + 1)
        rows.push_back(nlohmann::json::parse(said.substr(at, end - at)).get<std::vector<std::string>>());
    return rows;
}

TEST(DefectCsv, WritesOneRowADefect) {
    EXPECT_EQ(defect_csv({}), header);
    EXPECT_EQ(
        defect_csv({plain_record()}),
        std::string(header) +
            "1,2000-02-29T12:34:56.000001Z,bumper-front-a,0001,310.000,-20.500,120.000,0.000000,-1.000000,"
            "0.000000,upper left,left,0.875000,true,open,live,33333,,1,9,PAINT,MARK,1\r\n");
}

TEST(DefectCsv, CountsPositionsByPartAndNoWithdrawnDefects) {
    std::vector<DefectRecord> records;
    for (DefectId id = 1; id <= 4; ++id) records.push_back(plain_record(id));
    records[1].part_serial = "0002";
    records[2].state = DefectState::withdrawn;
    records[3].delivered_us = 0;
    QualityCodes codes;
    codes.code = "L17";
    const auto rows = read_by_python(defect_csv(records, codes));
    ASSERT_EQ(rows.size(), 5U);
    EXPECT_EQ((std::vector<std::string>(rows[1].end() - 5, rows[1].end())),
              (std::vector<std::string>{"1", "9", "PAINT", "L17", "1"}));
    EXPECT_EQ(rows[2][18], "1");
    EXPECT_EQ(rows[3][18], "2");
    EXPECT_EQ(rows[3][14], "withdrawn");
    EXPECT_EQ(rows[3][22], "0");
    EXPECT_EQ(rows[4][17], "1970-01-01T00:00:00.000000Z");
}

TEST(DefectCsv, UglyTextsComeBackAndNoneIsAFormula) {
    std::vector<DefectRecord> records;
    for (const std::string& text : ugly_texts()) {
        DefectRecord record = plain_record();
        record.zone = record.part_serial = record.part_type = record.source = text;
        records.push_back(record);
    }
    const auto rows = read_by_python(defect_csv(records));
    ASSERT_EQ(rows.size(), records.size() + 1);
    for (size_t i = 0; i < records.size(); ++i) {
        ASSERT_EQ(rows[i + 1].size(), 23U);
        std::string expected;
        for (const char c : valid_utf8(records[i].zone))
            expected += c == '\0' ? "\xEF\xBF\xBD" : std::string(1, c);
        std::string got = rows[i + 1][10];
        ASSERT_EQ(got.find_first_of("=+-@\t\r"),
                  got.empty() ? std::string::npos : got.find_first_of("=+-@\t\r", 1))
            << "begins like a formula: " << got;
        if (got != expected) {
            ASSERT_THAT(got, StartsWith("'"));
            got.erase(0, 1);
        }
        EXPECT_EQ(got, expected);
        for (const size_t column : {2U, 3U, 15U}) EXPECT_EQ(rows[i + 1][column], rows[i + 1][10]);
    }
    EXPECT_EQ(rows[1][10], "'=1+1");
    EXPECT_EQ(rows[8][10],
              "'\xEF\xBC\x9D"
              "1");
}

TEST(DefectCsv, NumbersAreNoFormulasAndHaveNoLocale) {
    DefectRecord record = plain_record();
    record.mark.spot.position = {-1e-9, -1234.5678, 1e9};
    const char* german = std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
    EXPECT_THAT(defect_csv({record}), HasSubstr(",0.000,-1234567.800,1000000000000.000,"));
    if (german != nullptr) std::setlocale(LC_NUMERIC, "C");
}

TEST(ValidUtf8, KeepsWhatIsValidAndMarksTheRest) {
    EXPECT_EQ(valid_utf8("caf\xc3\xa9 \xe4\xb8\xad \xf0\x9f\x94\xb4"),
              "caf\xc3\xa9 \xe4\xb8\xad \xf0\x9f\x94\xb4");
    const std::string bad = "\xEF\xBF\xBD";
    EXPECT_EQ(valid_utf8("a\xff"
                         "b"),
              "a" + bad + "b");
    EXPECT_EQ(valid_utf8("\xc3"), bad);
    EXPECT_EQ(valid_utf8("\xc0\xaf"), bad + bad);
    EXPECT_EQ(valid_utf8("\xed\xa0\x80"), bad + bad + bad);
    EXPECT_EQ(valid_utf8("\xf4\x90\x80\x80"), bad + bad + bad + bad);
    EXPECT_EQ(valid_utf8(std::string("\0", 1)), std::string("\0", 1));
}

TEST(QualityCodes, FitTheirColumns) {
    QualityCodes codes;
    EXPECT_TRUE(codes.validate().empty());
    codes = {"99", "NINECHARS", ""};
    EXPECT_EQ(codes.validate().size(), 3U);
    EXPECT_EQ(codes.validate()[1].key, "code_group");
    EXPECT_EQ(codes.validate()[1].range, "1 to 8 characters");
}

}  // namespace
}  // namespace deixis
