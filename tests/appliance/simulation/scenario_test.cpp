// Scenario files: what is read, what is refused and with which sentence.
#include "appliance/simulation/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "tests/appliance/simulation/small_cell.h"

namespace deixis {
namespace {

using testing::HasSubstr;

const std::string point = "[[action]]\ndo = \"point\"\narm = \"left\"\n";

TEST(Scenario, ReadsWhatStandsInTheFile) {
    const std::string text = small_scenario(R"(height = 1.8
aim = "finger"
scatter_deg = 2
gap = [0.05, 0.3]
[[action]]
do = "point"
arm = "left"
target = [0.1, 0.0, 0.2]
seconds = 1.5
touch = true
[[action]]
do = "push"
by = "corner"
to = [0.3, 0.9]
turn_deg = 90
pointing = true
[expected]
marks_found_min = 0.9
)");
    const Scenario s = parsed(replaced(
        text, "lower_edge = 0.65",
        "mounting_deg = [0, 0, 90]\nzones = [{name = \"all\", min = [-1, -1, -1], max = [1, 1, 2]}]"));
    EXPECT_EQ(s.name, "small");
    EXPECT_EQ(s.seed, 5U);
    EXPECT_EQ(s.part.model, "panel.stl");
    EXPECT_NEAR((s.part.mounting * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 0, 1e-12);
    ASSERT_EQ(s.part.zones.size(), 1U);
    EXPECT_EQ(s.part.zones[0].box.max, Eigen::Vector3d(1, 1, 2));
    ASSERT_EQ(s.sensors.size(), 2U);
    EXPECT_EQ(s.sensors[1].position, Eigen::Vector3d(2.1, -1.2, 2.4));
    EXPECT_EQ(s.worker.height, 1.8);
    EXPECT_FALSE(s.worker.build.has_value());
    EXPECT_EQ(s.worker.aim, AimMode::finger);
    EXPECT_NEAR(s.worker.scatter, 2 * std::numbers::pi / 180, 1e-12);
    EXPECT_EQ(s.worker.gap_max, 0.3);
    ASSERT_EQ(s.actions.size(), 2U);
    EXPECT_EQ(s.actions[0].left_arm, true);
    EXPECT_EQ(s.actions[0].target, Eigen::Vector3d(0.1, 0, 0.2));
    EXPECT_TRUE(s.actions[0].touch && s.actions[0].meant);
    EXPECT_FALSE(s.actions[1].by_end);
    EXPECT_TRUE(s.actions[1].pointing);
    EXPECT_NEAR(s.actions[1].to.turn, std::numbers::pi / 2, 1e-12);
    ASSERT_EQ(s.expected.size(), 1U);
    EXPECT_TRUE(s.warnings.empty());
}

struct BadScenario {
    const char* from;
    const char* to;
    const char* sentence;
};

class BadScenarios : public testing::TestWithParam<BadScenario> {};

TEST_P(BadScenarios, AreRefusedInOneSentence) {
    const std::string text = replaced(small_scenario(point), GetParam().from, GetParam().to);
    const auto scenario = parse_scenario(text, "cell.toml");
    ASSERT_FALSE(scenario.has_value());
    EXPECT_THAT(scenario.error().sentence, HasSubstr(GetParam().sentence));
    EXPECT_THAT(scenario.error().sentence, HasSubstr("cell.toml: "));
    EXPECT_EQ(scenario.error().sentence.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Each, BadScenarios,
    testing::Values(
        BadScenario{"format = ", "format == ", "cell.toml: line 1: "},
        BadScenario{"deixis-scenario/1", "deixis-scenario/2", "key \"format\" must be \"deixis-scenario/1\""},
        BadScenario{"seed = 5", "seed = -1", "key \"seed\" must be a whole number from 0"},
        BadScenario{"seed = 5", "seed = 1.5", "key \"seed\" must be a whole number"},
        BadScenario{"seed = 5", "fps = 500", "key \"fps\" must be a number from 1 to 60, not 500"},
        BadScenario{"seed = 5", "fps = nan", "key \"fps\" must be a number from 1 to 60, not nan"},
        BadScenario{"seed = 5", "clutter = 1", "key \"clutter\" must be true or false"},
        BadScenario{"seed = 5", "cell = 3", "key \"cell\" must be a table"},
        BadScenario{"seed = 5", "cell = {min = [0, 0, 0], max = [0, 1, 1]}",
                    "key \"cell.min\" must lie below \"max\""},
        BadScenario{"seed = 5", "cell = {pointing_axis = [0, 0, 0]}",
                    "key \"cell.pointing_axis\" must not be zero"},
        BadScenario{"name = \"small\"", "name = \"\"", "key \"name\" must be a text that is not empty"},
        BadScenario{"model = \"panel.stl\"", "",
                    "key \"part.model\" or \"sample\" must be given, one of the two"},
        BadScenario{"model = \"panel.stl\"", "model = \"panel.stl\"\nsample = \"a\"", "one of the two"},
        BadScenario{"model = \"panel.stl\"", "sample = \"z\"",
                    "key \"part.sample\" must be one of \"a\", \"b\", not \"z\""},
        BadScenario{"units = \"m\"", "units = \"inch\"",
                    "key \"part.units\" must be one of \"mm\", \"m\", not \"inch\""},
        BadScenario{"lower_edge = 0.65", "lower_edge = 9",
                    "key \"part.lower_edge\" must be a number from 0.3 to 1.5, not 9"},
        BadScenario{"lower_edge = 0.65", "mounting_deg = [1, 2]",
                    "key \"part.mounting_deg\" must be a list of 3 numbers"},
        BadScenario{"start = [0.0, 0.75]", "start_turn_deg = 4",
                    "key \"part.start\" is missing beside \"start_turn_deg\""},
        BadScenario{"start = [0.0, 0.75]", "start = [0.0, \"x\"]", "key \"part.start\" must be a number"},
        BadScenario{"start = [0.0, 0.75]", "zones = [{name = \"a\"}]",
                    "key \"part.zones[1].min\" and \"max\" must both be given"},
        BadScenario{"width = 160", "width = 10",
                    "key \"optics.width\" must be a whole number from 64 to 1280"},
        BadScenario{"width = 160", "noise = -1",
                    "key \"optics.noise\" must be a number from 0 to 10, not -1"},
        BadScenario{"name = \"right\"", "name = \"left\"", "key \"sensor[2].name\" \"left\" is used twice"},
        BadScenario{"name = \"right\"", "", "key \"sensor[2].name\" is missing"},
        BadScenario{"name = \"right\"", "name = \"../right\"",
                    "key \"sensor[2].name\" must hold only letters, digits"},
        BadScenario{"position = [2.1, -1.2, 2.4]", "", "key \"sensor[2].position\" is missing"},
        BadScenario{"look_at = [-0.1, 0.45, 0.95]", "look_at = [2.1, -1.2, 0]",
                    "key \"sensor[2].look_at\" must lie at least 10 cm"},
        BadScenario{"[worker]", "[worker]\nheight = 3",
                    "key \"worker.height\" must be a number from 1.4 to 2.1, not 3"},
        BadScenario{"[worker]", "[worker]\naim = \"nose\"",
                    "key \"worker.aim\" must be one of \"eye\", \"forearm\", \"finger\""},
        BadScenario{"[worker]", "[worker]\ngap = [0.3, 0.1]",
                    "key \"worker.gap\" must hold the least and the greatest"},
        BadScenario{"[worker]", "[worker]\nclip = \"walk.bvh\"",
                    "key \"worker.clip\" and [[action]] exclude each other"},
        BadScenario{"[worker]", "[worker]\nclip = \"walk.amc\"", "key \"worker.clip_skeleton\" is missing"},
        BadScenario{"[worker]", "[worker]\nclip_skeleton = \"a.asf\"",
                    "key \"worker.clip_skeleton\" has no meaning"},
        BadScenario{"[worker]", "", "key \"action\" needs a worker"},
        BadScenario{"do = \"point\"", "do = \"fly\"", "key \"action[1].do\" must be one of \"wait\""},
        BadScenario{"do = \"point\"", "", "key \"action[1].do\" is missing"},
        BadScenario{"do = \"point\"", "do = \"push\"", "key \"action[1].to\" is missing"},
        BadScenario{"do = \"point\"", "do = \"push\"\nto = [0, 1]\npointing = true",
                    "key \"action[1].pointing\" needs a free hand"},
        BadScenario{"do = \"point\"", "do = \"point\"\nseconds = 0",
                    "key \"action[1].seconds\" must be a number from 0.05"},
        BadScenario{"arm = \"left\"", "arm = \"both\"",
                    "key \"action[1].arm\" must be one of \"left\", \"right\", not \"both\""},
        BadScenario{"arm = \"left\"", "target = [0, 0]",
                    "key \"action[1].target\" must be a list of 3 numbers"},
        BadScenario{"arm = \"left\"", "meant = \"yes\"", "key \"action[1].meant\" must be true or false"},
        BadScenario{"arm = \"left\"", "[expected]\nmarks_found_min = \"all\"",
                    "key \"expected.marks_found_min\" must be a number"}));

TEST(Scenario, RefusesWhatIsNoFile) {
    const auto scenario = read_scenario("no-such-folder/cell.toml");
    ASSERT_FALSE(scenario.has_value());
    EXPECT_EQ(scenario.error().sentence, "no-such-folder/cell.toml: cannot be opened");
}

TEST(Scenario, WarnsOfUnknownKeys) {
    const Scenario s =
        parsed(replaced(small_scenario(point), "units = \"m\"", "units = \"m\"\ncolour = \"red\""));
    ASSERT_EQ(s.warnings.size(), 1U);
    EXPECT_EQ(s.warnings[0], "cell.toml: key \"part.colour\" is unknown and was ignored");
}

TEST(Scenario, NeedsALengthWithoutActions) {
    const auto scenario = parse_scenario(small_scenario(""), "cell.toml");
    ASSERT_FALSE(scenario.has_value());
    EXPECT_THAT(scenario.error().sentence, HasSubstr("key \"seconds\" is missing"));
}

TEST(Scenario, TheDemoReadsWithoutWarning) {
    const char* source = std::getenv("DEIXIS_SOURCE");
    ASSERT_NE(source, nullptr) << "set by CTest";
    const auto demo = read_scenario(std::filesystem::path(source) / "deploy/scenarios/demo.toml");
    ASSERT_TRUE(demo.has_value()) << demo.error().sentence;
    EXPECT_TRUE(demo->warnings.empty()) << demo->warnings[0];
}

}  // namespace
}  // namespace deixis
