// Settings: what is good is taken, what is not is refused with one sentence naming file, key, value and
// range.
#include "appliance/station/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

namespace deixis {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Settings, DefaultsAreValidAndDescribeThemselves) {
    const auto file = parse_settings("", "s.toml");
    ASSERT_TRUE(file) << file.error().sentence;
    EXPECT_THAT(file->warnings, IsEmpty());
}

TEST(Settings, DescriptionReadBackUncommentedGivesTheSameDescription) {
    Settings defaults;
    std::string text = describe_settings(settings_table(defaults));
    std::string uncommented;
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '#' && (i == 0 || text[i - 1] == '\n')) {
            ++i;
            continue;
        }
        uncommented += text[i];
    }
    auto file = parse_settings(uncommented, "s.toml");
    ASSERT_TRUE(file) << file.error().sentence;
    EXPECT_THAT(file->warnings, IsEmpty());
    EXPECT_EQ(describe_settings(settings_table(file->settings)), text);
}

TEST(Settings, ValuesAreTaken) {
    const auto file = parse_settings(R"([gesture]
dwell_s = 2
[stillness]
gap_s = 0.3
[plc]
mode = "server"
port = 1602
[record]
check_on_open = false
)",
                                     "s.toml");
    ASSERT_TRUE(file) << file.error().sentence;
    EXPECT_EQ(file->settings.perception.gesture.stillness.dwell_s, 2.0);
    EXPECT_EQ(file->settings.perception.gesture.stillness.gap_s, 0.3);
    EXPECT_EQ(file->settings.plc.mode, "server");
    EXPECT_EQ(file->settings.plc.port, 1602);
    EXPECT_FALSE(file->settings.ledger.check_on_open);
}

TEST(Settings, UnknownKeysAndSectionsAreWarnings) {
    const auto file = parse_settings("[gesture]\ndwel_s = 2.0\n[lamp]\ncolour = 1\n", "s.toml");
    ASSERT_TRUE(file);
    EXPECT_THAT(file->warnings, ElementsAre("s.toml: unknown key gesture.dwel_s is ignored",
                                            "s.toml: unknown section lamp is ignored"));
}

struct BadSettings {
    const char* text;
    const char* sentence;
};

class SettingsRefusal : public testing::TestWithParam<BadSettings> {};

TEST_P(SettingsRefusal, NamesFileKeyValueAndRange) {
    const auto file = parse_settings(GetParam().text, "s.toml");
    ASSERT_FALSE(file) << GetParam().text;
    EXPECT_THAT(file.error().sentence, HasSubstr(GetParam().sentence));
    EXPECT_EQ(file.error().sentence.find('\n'), std::string::npos) << "one sentence";
}

INSTANTIATE_TEST_SUITE_P(
    Bad, SettingsRefusal,
    testing::Values(
        BadSettings{"[gesture\ndwell_s = 1.0", "s.toml: line 1 is not TOML: "},
        BadSettings{"[gesture]\ndwell_s = ", "s.toml: line 2 is not TOML: "},
        BadSettings{"[gesture]\ndwell_s = 1.0\ndwell_s = 2.0", "s.toml: line 3 is not TOML: "},
        BadSettings{"\xff\xfe\x01", "s.toml: line 1 is not TOML: "},
        BadSettings{"[part]\na = i\nb = 1", "s.toml: line 2 is not TOML: "},
        BadSettings{"[plc]\nmode = \"a\\nb\"", "s.toml: plc.mode is "},
        BadSettings{"gesture = 3", "s.toml: gesture is 3, expected a section [gesture]"},
        BadSettings{"[[gesture]]\ndwell_s = 1.0",
                    "s.toml: gesture is an array, expected a section [gesture]"},
        BadSettings{"[gesture]\ndwell_s = \"long\"",
                    "s.toml: gesture.dwell_s is 'long', expected a finite number"},
        BadSettings{"[gesture]\ndwell_s = true", "s.toml: gesture.dwell_s is true, expected a finite number"},
        BadSettings{"[gesture]\ndwell_s = nan", "s.toml: gesture.dwell_s is nan, expected a finite number"},
        BadSettings{"[gesture]\ndwell_s = inf", "s.toml: gesture.dwell_s is inf, expected a finite number"},
        BadSettings{"[gesture]\ndwell_s = [1.0]",
                    "s.toml: gesture.dwell_s is an array, expected a finite number"},
        BadSettings{"[gesture]\ndwell_s = {a = 1}",
                    "s.toml: gesture.dwell_s is a table, expected a finite number"},
        BadSettings{"[gesture]\ndwell_s = -1.0", "s.toml: gesture.dwell_s is -1.0"},
        BadSettings{"[gesture]\ndwell_s = 1e300", "s.toml: gesture.dwell_s is "},
        BadSettings{"[gesture]\neye_weight = 1.5", "s.toml: gesture.eye_weight is 1.5"},
        BadSettings{"[gesture]\nreach_out_m = -1.0", "s.toml: gesture.reach_out_m is -1.0"},
        BadSettings{"[limb]\nmin_length_m = 0.0", "s.toml: limb.min_length_m is 0.0"},
        BadSettings{"[arm]\nmin_length_m = 0.0", "s.toml: arm.min_length_m is 0.0"},
        BadSettings{"[pointing]\nsnap_m = 3.0", "s.toml: pointing.snap_m is 3.0"},
        BadSettings{"[stillness]\ngap_s = 9.0", "s.toml: stillness.gap_s is 9.0"},
        BadSettings{"[foreground]\nneighbours = 2.5",
                    "s.toml: foreground.neighbours is 2.5, expected a whole number"},
        BadSettings{"[foreground]\nneighbours = 99", "s.toml: foreground.neighbours is 99"},
        BadSettings{"[foreground]\nmoved_frames = 99999999999",
                    "s.toml: foreground.moved_frames is 99999999999, expected a whole number"},
        BadSettings{"[surface]\nstride = 0", "s.toml: surface.stride is 0"},
        BadSettings{"[carving]\nvoxel_m = 0.0", "s.toml: carving.voxel_m is 0.0"},
        BadSettings{"[carving]\nvoxel_m = 1e-9", "s.toml: carving.voxel_m is "},
        BadSettings{"[part]\nfound_fitness = 7", "s.toml: part.found_fitness is 7"},
        BadSettings{"[record]\ncheck_on_open = 1",
                    "s.toml: record.check_on_open is 1, expected true or false"},
        BadSettings{"[perception]\nthreads = 0", "s.toml: perception.threads is 0"},
        BadSettings{"[reference]\nfine_spacing = -0.01", "s.toml: reference.fine_spacing is -0.01"},
        BadSettings{"[recorder]\nqueue_length = 0", "s.toml: recorder.queue_length is 0"},
        BadSettings{"[plc]\nmode = \"master\"", "s.toml: plc.mode is "},
        BadSettings{"[plc]\nport = 70000", "s.toml: plc.port is 70000"},
        BadSettings{"[plc]\naddress = \"plc.example\"", "s.toml: plc.address is "},
        BadSettings{"[plc]\naddress = 127", "s.toml: plc.address is 127, expected a text"},
        BadSettings{"[screen]\nhost = \"0.0.0.0\"",
                    "s.toml: screen.host is \"0.0.0.0\", allowed is \"127.0.0.1\""},
        BadSettings{"[screen]\nport = -1", "s.toml: screen.port is -1"},
        BadSettings{"[sensors]\nstall_limit_ms = 1", "s.toml: sensors.stall_limit_ms is 1"},
        BadSettings{"[station]\ndatabase = \"\"",
                    "s.toml: station.database is empty, allowed is a file name"}));

TEST(Settings, MissingFileIsASentence) {
    const auto file = read_settings("/nonexistent/settings.toml");
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().sentence, "/nonexistent/settings.toml: cannot be read, expected a settings file");
}

TEST(Settings, HugeFileIsRefusedUnread) {
    const std::string path = testing::TempDir() + "huge_settings.toml";
    std::ofstream(path) << std::string(2 << 20, '#');
    const auto file = read_settings(path);
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().sentence, path + ": holds 2097152 bytes, expected at most 1 MB of settings");
    std::remove(path.c_str());
}

TEST(Settings, PathsAreRelativeToTheFile) {
    const std::string path = testing::TempDir() + "paths_settings.toml";
    std::ofstream(path) << "[station]\npart = \"part.toml\"\ndatabase = \"/var/lib/deixis.db\"\n";
    const auto file = read_settings(path);
    ASSERT_TRUE(file) << file.error().sentence;
    EXPECT_EQ(file->settings.station.part, testing::TempDir() + "part.toml");
    EXPECT_EQ(file->settings.station.database, "/var/lib/deixis.db");
    std::remove(path.c_str());
}

}  // namespace
}  // namespace deixis
