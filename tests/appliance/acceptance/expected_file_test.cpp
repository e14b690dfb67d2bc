// expected.toml: what is read and what is refused.
#include "appliance/acceptance/expected_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

namespace deixis {
namespace {

class ExpectedFile : public testing::Test {
  protected:
    Result<Expected> expected_of(const std::string& text) const {
        std::ofstream(path_) << text;
        return read_expected(path_);
    }
    void TearDown() override { std::filesystem::remove(path_); }

    std::string path_ = testing::TempDir() + "expected_file_test.toml";
};

TEST_F(ExpectedFile, ReadsWhatStandsAndLeavesTheRestOpen) {
    const auto expected =
        expected_of("marks_found_min = 1\npart_mm_max = 10.5\nfalse_marks_max = 0\nhue = 3\n");
    ASSERT_TRUE(expected) << expected.error().sentence;
    EXPECT_EQ(expected->marks_found_min, 1.0);
    EXPECT_EQ(expected->part_mm_max, 10.5);
    EXPECT_EQ(expected->false_marks_max, 0.0);
    EXPECT_FALSE(expected->pcp_min);
    EXPECT_THAT(expected->warnings, testing::ElementsAre(path_ + ": unknown key hue"));
}

TEST_F(ExpectedFile, RefusesWhatCannotBeACriterion) {
    for (const char* bad :
         {"= \"all\"", "= -0.1", "= 1.1", "= nan", "= inf", "= true", "= [1]", "= 1979-05-27"}) {
        const auto expected = expected_of(std::string("marks_found_min ") + bad);
        ASSERT_FALSE(expected) << bad;
        EXPECT_EQ(expected.error().sentence, path_ + ": marks_found_min must be a share from 0 to 1");
    }
    EXPECT_EQ(expected_of("part_mm_max = -1").error().sentence,
              path_ + ": part_mm_max must be a number of 0 or more");
    EXPECT_THAT(expected_of("\npart_mm_max = = 3").error().sentence,
                testing::StartsWith(path_ + " line 2: "));
    EXPECT_EQ(expected_of("pcp_min = f\n").error().sentence.find('\n'), std::string::npos);
    EXPECT_THAT(read_expected("/no/such.toml").error().sentence, testing::StartsWith("/no/such.toml"));
}

}  // namespace
}  // namespace deixis
