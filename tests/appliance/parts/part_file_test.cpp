// part.toml: what is read, and the sentence for everything that is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "appliance/parts/part_model.h"

namespace deixis {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

class PartFileTest : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("deixis-part-file-" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path written(const std::string& text) {
        std::ofstream(folder_ / "part.toml") << text;
        return folder_ / "part.toml";
    }
    std::string refusal(const std::string& text) {
        const auto part = read_part_file(written(text));
        return part ? "accepted" : part.error().sentence;
    }

    std::filesystem::path folder_;
};

const std::string head = "type = \"bumper\"\nserial = \"0001\"\nmodel = \"bumper.stl\"\nunits = \"mm\"\n";

TEST_F(PartFileTest, ReadsEveryKey) {
    const auto part = read_part_file(written(head + R"(
[[zones]]
name = "upper left"
min = [-0.85, -0.3, 0.3]
max = [0, 0.3, 0.6]
[[zones]]
name = "rest"
min = [-1, -1, -1]
max = [1, 1, 1]
)"));
    ASSERT_TRUE(part) << part.error().sentence;
    EXPECT_EQ(part->type, "bumper");
    EXPECT_EQ(part->serial, "0001");
    EXPECT_EQ(part->model, folder_ / "bumper.stl");
    EXPECT_DOUBLE_EQ(part->metres_per_unit, 0.001);
    EXPECT_TRUE(part->warnings.empty());
    ASSERT_EQ(part->zones.size(), 2U);
    EXPECT_EQ(zone_of(part->zones, {-0.5, 0, 0.4}), "upper left");
    EXPECT_EQ(zone_of(part->zones, {0.5, 0, 0.4}), "rest");
    EXPECT_EQ(zone_of(part->zones, {0, 0.3, 0.6}), "upper left") << "borders belong to the box";
    EXPECT_EQ(zone_of(part->zones, {0, 0, 3}), "");
}

TEST_F(PartFileTest, MetresAndUnknownKeys) {
    const auto part = read_part_file(
        written("type = \"x\"\nserial = \"1\"\nmodel = \"/a/b.ply\"\nunits = \"m\"\ncolour = \"red\"\n"
                "[[zones]]\nname = \"z\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nshape = 3\n"));
    ASSERT_TRUE(part) << part.error().sentence;
    EXPECT_DOUBLE_EQ(part->metres_per_unit, 1);
    EXPECT_EQ(part->model, "/a/b.ply");
    EXPECT_THAT(part->warnings, ElementsAre(EndsWith("unknown key `zones[0].shape` is ignored."),
                                            EndsWith("unknown key `colour` is ignored.")));
}

TEST_F(PartFileTest, RefusesWithOneSentence) {
    const auto part = (folder_ / "part.toml").string();
    EXPECT_EQ(read_part_file(folder_ / "none.toml").error().sentence,
              (folder_ / "none.toml").string() + ": there is no such part file.");
    EXPECT_EQ(read_part_file(folder_).error().sentence, folder_.string() + ": there is no such part file.");
    EXPECT_EQ(refusal(""), part + ": `type` must be a text that is not empty.");
    EXPECT_EQ(refusal("type = 3"), part + ": `type` must be a text that is not empty.");
    EXPECT_EQ(refusal("type = \"\""), part + ": `type` must be a text that is not empty.");
    EXPECT_EQ(refusal("type = \"a\""), part + ": `serial` must be a text that is not empty.");
    EXPECT_EQ(refusal("type = \"a\"\nserial = \"1\""), part + ": `model` must be a text that is not empty.");
    EXPECT_EQ(refusal("type = \"a\"\nserial = \"1\"\nmodel = [1]"),
              part + ": `model` must be a text that is not empty.");
    EXPECT_EQ(refusal("type = \"a\"\nserial = \"1\"\nmodel = \"m\""),
              part + ": `units` must be a text that is not empty.");
    EXPECT_EQ(refusal("type = \"a\"\nserial = \"1\"\nmodel = \"m\"\nunits = \"inch\""),
              part + ": `units` is \"inch\", expected \"mm\" or \"m\".");
    EXPECT_EQ(refusal(head + "zones = 4"), part + ": `zones` must be a list of tables, written [[zones]].");
    EXPECT_EQ(refusal(head + "zones = [1, 2]"),
              part + ": `zones` must be a list of tables, written [[zones]].");
    EXPECT_EQ(refusal(head + "[[zones]]"), part + ": `zones[0].name` must be a text that is not empty.");
    EXPECT_EQ(refusal(head + "[[zones]]\nname = \"z\""),
              part + ": `zones[0].min` must be three numbers, metres between -100 and 100.");
    const std::string zone = head + "[[zones]]\nname = \"z\"\n";
    EXPECT_EQ(refusal(zone + "min = [0, 0]"),
              part + ": `zones[0].min` must be three numbers, metres between -100 and 100.");
    EXPECT_EQ(refusal(zone + "min = [0, nan, 0]"),
              part + ": `zones[0].min` must be three numbers, metres between -100 and 100.");
    EXPECT_EQ(refusal(zone + "min = [0, 0, 0]\nmax = [0, 0, 1e9]"),
              part + ": `zones[0].max` must be three numbers, metres between -100 and 100.");
    EXPECT_EQ(refusal(zone + "min = [0, 0, \"0\"]"),
              part + ": `zones[0].min` must be three numbers, metres between -100 and 100.");
    EXPECT_EQ(refusal(zone + "min = [0, 0, 1]\nmax = [1, 1, 0]"),
              part + ": `zones[0].min` must not be above `zones[0].max`.");
    EXPECT_THAT(refusal("type = "), HasSubstr("part.toml: line 1 is not TOML ("));
    EXPECT_THAT(refusal(head + "type = \"again\""), HasSubstr("part.toml: line 5 is not TOML ("));
    EXPECT_THAT(refusal(std::string("type = \"\xff\xfe\"")), HasSubstr("part.toml: line 1 is not TOML ("));
    EXPECT_EQ(refusal(head + "# " + std::string(1'000'001, 'x')),
              part + ": the part file is larger than 1 MB.");
}

}  // namespace
}  // namespace deixis
