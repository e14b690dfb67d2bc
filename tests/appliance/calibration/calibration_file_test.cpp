// calibration.toml: values survive writing and reading to the bit; each bad file gets one sentence.
#include "appliance/calibration/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>

#include "appliance/calibration/toml_section.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

fs::path temporary(const std::string& name) {
    return fs::path(::testing::TempDir()) / ("calibration_file_test_" + name);
}

const char* const good = R"(format = "deixis-calibration/1"

[cell]
min = [-2.0, -1.5, 0]
max = [2.0, 1.5, 2.2]
pointing_axis = [0, 2, 0]

[[sensor]]
name = "left"
kind = "depth"
width = 640
height = 480
fx = 575.8
fy = 575
cx = 319.5
cy = 239.5
distortion = [0.1, -0.2, 0.001, 0, 3e-2]
rotation = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
translation = [0, 0.5, 1]
uri = "freenect://0"

[[sensor]]
name = "top view"
kind = "video"
width = 1920
height = 1080
fx = 1000.0
fy = 1000.0
cx = 960
cy = 540
rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
translation = [0, 0, 0]
)";

std::string edited(const std::string& from, const std::string& to) {
    std::string text = good;
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(CalibrationFile, ReadsEveryKey) {
    const auto file = parse_calibration(good, "c.toml");
    ASSERT_TRUE(file) << file.error().sentence;
    EXPECT_TRUE(file->warnings.empty());
    const SensorRig& rig = file->rig;
    ASSERT_EQ(rig.sensors.size(), 2U);
    EXPECT_EQ(rig.cell->max, Eigen::Vector3d(2.0, 1.5, 2.2));
    EXPECT_EQ(*rig.pointing_axis, Eigen::Vector3d(0, 1, 0)) << "made a unit vector";
    const CalibratedSensor& left = rig.sensors[0];
    EXPECT_EQ(left.name, "left");
    EXPECT_EQ(left.kind, SensorKind::depth);
    EXPECT_EQ(left.camera.width, 640);
    EXPECT_EQ(left.camera.height, 480);
    EXPECT_EQ(left.camera.fx, 575.8);
    EXPECT_EQ(left.camera.fy, 575.0);
    EXPECT_EQ(left.camera.cx, 319.5);
    EXPECT_EQ(left.camera.cy, 239.5);
    EXPECT_EQ(left.camera.distortion, (std::array<double, 5>{0.1, -0.2, 0.001, 0, 3e-2}));
    EXPECT_EQ(left.camera_from_world * Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(1, 3.5, -1));
    EXPECT_EQ(left.uri, "freenect://0");
    EXPECT_EQ(rig.sensors[1].kind, SensorKind::video);
    EXPECT_EQ(rig.sensors[1].camera.distortion, (std::array<double, 5>{0, 0, 0, 0, 0}));
    EXPECT_EQ(rig.sensors[1].uri, "");
}

TEST(CalibrationFile, MarksOfOtherEditorsPass) {
    std::string text = std::string("\xEF\xBB\xBF") + good;
    for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.replace(at, 1, "\r\n");
    const auto file = parse_calibration(text, "c.toml");
    ASSERT_TRUE(file) << file.error().sentence;
    EXPECT_EQ(file->rig.sensors.size(), 2U);
}

TEST(CalibrationFile, CellAndAxisAreOptional) {
    const auto bare = parse_calibration(
        edited("[cell]\nmin = [-2.0, -1.5, 0]\nmax = [2.0, 1.5, 2.2]\npointing_axis = [0, 2, 0]", ""), "c");
    ASSERT_TRUE(bare) << bare.error().sentence;
    EXPECT_FALSE(bare->rig.cell || bare->rig.pointing_axis);
    const auto axis = parse_calibration(edited("min = [-2.0, -1.5, 0]\nmax = [2.0, 1.5, 2.2]\n", ""), "c");
    ASSERT_TRUE(axis) << axis.error().sentence;
    EXPECT_TRUE(!axis->rig.cell && axis->rig.pointing_axis);
}

/// A rotation from random angles, its rows as exact as doubles are.
Eigen::Matrix3d random_rotation(std::mt19937& random) {
    std::uniform_real_distribution<double> angle(-3, 3);
    return (Eigen::AngleAxisd(angle(random), Eigen::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(angle(random), Eigen::Vector3d::UnitY()) *
            Eigen::AngleAxisd(angle(random), Eigen::Vector3d::UnitX()))
        .toRotationMatrix();
}

bool same_bits(const CalibratedSensor& a, const CalibratedSensor& b) {
    const auto equal = [](const void* x, const void* y, size_t size) { return std::memcmp(x, y, size) == 0; };
    return a.name == b.name && a.kind == b.kind && a.uri == b.uri && a.camera.width == b.camera.width &&
           a.camera.height == b.camera.height && equal(&a.camera.fx, &b.camera.fx, 4 * sizeof(double)) &&
           equal(a.camera.distortion.data(), b.camera.distortion.data(), 5 * sizeof(double)) &&
           equal(a.camera_from_world.rotation.data(), b.camera_from_world.rotation.data(),
                 9 * sizeof(double)) &&
           equal(a.camera_from_world.translation.data(), b.camera_from_world.translation.data(),
                 3 * sizeof(double));
}

TEST(CalibrationFile, ValuesSurviveToTheLastBit) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> any(-1, 1);
    const fs::path path = temporary("bits.toml");
    for (int trial = 0; trial < 50; ++trial) {
        SensorRig rig;
        rig.cell =
            Box{Eigen::Vector3d(any(random) - 2, any(random) - 2, -0.0), Eigen::Vector3d(2, 3, 1e-300)};
        rig.pointing_axis = Eigen::Vector3d(any(random), any(random), any(random)).normalized();
        for (const SensorKind kind : {SensorKind::depth, SensorKind::infrared, SensorKind::video}) {
            CalibratedSensor sensor;
            sensor.name = "sensor " + std::to_string(rig.sensors.size());
            sensor.kind = kind;
            sensor.camera.width = 1 + static_cast<int>(random() % 2000);
            sensor.camera.height = 1 + static_cast<int>(random() % 2000);
            sensor.camera.fx = 500 + any(random);
            sensor.camera.fy = 1e5 + any(random);
            sensor.camera.cx = any(random) * 1e-9;
            sensor.camera.cy = trial % 2 == 0 ? 240 : -0.0;
            for (double& k : sensor.camera.distortion) k = any(random) * std::pow(10.0, any(random) * 20);
            sensor.camera_from_world = {random_rotation(random),
                                        Eigen::Vector3d(any(random), -0.0, any(random) * 1e-200)};
            sensor.uri = "a \"quoted\"\\path\n\t\x01\x7F \xC3\xBC";
            rig.sensors.push_back(sensor);
        }
        const auto written = write_calibration(rig, path);
        ASSERT_TRUE(written) << written.error().sentence;
        const auto read = read_calibration(path);
        ASSERT_TRUE(read) << read.error().sentence;
        ASSERT_EQ(read->rig.sensors.size(), 3U);
        for (size_t i = 0; i < 3; ++i) ASSERT_TRUE(same_bits(read->rig.sensors[i], rig.sensors[i])) << i;
        ASSERT_EQ(read->rig.cell->min, rig.cell->min);
        ASSERT_EQ(read->rig.cell->max, rig.cell->max);
        ASSERT_EQ(*read->rig.pointing_axis, *rig.pointing_axis);
        ASSERT_EQ(calibration_text(read->rig), calibration_text(rig));
    }
    fs::remove(path);
}

struct BadFile {
    std::string text;
    const char* sentence;
};

std::vector<BadFile> bad_files() {
    const std::string rotation = "rotation = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]";
    const std::string nines = "[9, 9, 9]";
    return {
        {"", "key 'format': expected \"deixis-calibration/1\", found nothing"},
        {"\x01", "line 1, column 1: expected TOML"},
        {std::string("\xFF\xFE") + good, "line 1, column 1: expected TOML"},
        {std::string(good) + "[[sensor]", "expected TOML"},
        {"format = " + std::string(100'000, '['), "expected TOML"},
        {edited("fx = 575.8", "fx = t"), "line 13, column "},
        {edited("\"left\"", "\"a\\nb\""), "key 'sensor[0].name': expected a name without slash"},
        {edited("\"depth\"", "\"so\\nnar\""), "key 'sensor[0].kind': expected"},
        {edited("calibration/1", "calibration/2"),
         "key 'format': expected \"deixis-calibration/1\", found \"deixis-calibration/2\""},
        {"format = \"deixis-calibration/1\"", "key 'sensor': expected 1 to 64 tables headed [[sensor]]"},
        {"format = \"deixis-calibration/1\"\nsensor = [1]",
         "key 'sensor': expected tables headed [[sensor]], found [ 1 ]"},
        {"format = \"deixis-calibration/1\"\n[sensor]\nname = \"a\"",
         "key 'sensor': expected tables headed [[sensor]], found a table"},
        {edited("name = \"left\"\n", ""), "key 'sensor[0].name': expected the sensor's name, found nothing"},
        {edited("\"left\"", "\"\""), "key 'sensor[0].name': expected 1 to 64 bytes, found \"\""},
        {edited("\"left\"", "\"a/b\""),
         "key 'sensor[0].name': expected a name without slash, backslash and control characters"},
        {edited("\"left\"", "\"..\""),
         "key 'sensor[0].name': expected a name that does not begin with a dot"},
        {edited("\"left\"", "\"a\\u0000b\""), "key 'sensor[0].name': expected a name without slash"},
        {edited("\"left\"", "\"background\""),
         "key 'sensor[0].name': expected another name than that of the folder"},
        {edited("\"left\"", '"' + std::string(65, 'n') + '"'),
         "key 'sensor[0].name': expected 1 to 64 bytes"},
        {edited("\"top view\"", "\"left\""),
         "key 'sensor[1].name': expected a name that no other sensor has, found \"left\""},
        {edited("kind = \"depth\"\n", ""),
         "key 'sensor[0].kind': expected \"depth\", \"infrared\" or \"video\", found nothing"},
        {edited("\"depth\"", "\"sonar\""),
         "key 'sensor[0].kind': expected \"depth\", \"infrared\" or \"video\", found \"sonar\""},
        {edited("width = 640", "width = 0"),
         "key 'sensor[0].width': expected a whole number from 1 to 16384, found 0"},
        {edited("width = 640", "width = 640.0"),
         "key 'sensor[0].width': expected a whole number from 1 to 16384, found 640.0"},
        {edited("height = 480", "height = 4294967776"),
         "key 'sensor[0].height': expected a whole number from 1 to 16384"},
        {edited("width = 640", "width = \"640\""), "key 'sensor[0].width': expected a whole number"},
        {edited("fx = 575.8", "fx = 0"), "key 'sensor[0].fx': expected a focal length in pixels"},
        {edited("fx = 575.8", "fx = -575.8"),
         "key 'sensor[0].fx': expected a focal length in pixels, above 0 and at most 1e6, found -575.8"},
        {edited("fy = 575", "fy = nan"), "key 'sensor[0].fy': expected a focal length in pixels"},
        {edited("fy = 575", "fy = true"), "key 'sensor[0].fy': expected a focal length in pixels"},
        {edited("cx = 319.5", "cx = inf"), "key 'sensor[0].cx': expected a number of pixels"},
        {edited("cy = 239.5", "cy = 1e9"), "key 'sensor[0].cy': expected a number of pixels"},
        {edited("cy = 239.5\n", ""),
         "key 'sensor[0].cy': expected a number of pixels between -1e6 and 1e6, found nothing"},
        {edited("[0.1, -0.2, 0.001, 0, 3e-2]", "[0, 0, 0, 0]"),
         "key 'sensor[0].distortion': expected five finite numbers"},
        {edited("[0.1, -0.2, 0.001, 0, 3e-2]", "[0, 0, nan, 0, 0]"),
         "key 'sensor[0].distortion': expected five finite numbers"},
        {edited(rotation, ""),
         "key 'sensor[0].rotation': expected 3 rows of 3 finite numbers, found nothing"},
        {edited(rotation, "rotation = [1, 0, 0, 0, 1, 0, 0, 0, 1]"),
         "key 'sensor[0].rotation': expected 3 rows of 3 finite numbers"},
        {edited(rotation, "rotation = [[1, 0, 0], [0, 1, 0]]"),
         "key 'sensor[0].rotation': expected 3 rows of 3 finite numbers"},
        {edited(rotation, "rotation = [[1, 0, 0], [0, nan, 0], [0, 0, 1]]"),
         "key 'sensor[0].rotation': expected 3 rows of 3 finite"},
        {edited(rotation, "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1.0002]]"),
         "key 'sensor[0].rotation': expected orthonormal rows to 1e-4"},
        {edited(rotation, "rotation = [[1e200, 0, 0], [0, 1e200, 0], [0, 0, 1e200]]"),
         "key 'sensor[0].rotation': expected orthonormal rows"},
        {edited(rotation, "rotation = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]"),
         "key 'sensor[0].rotation': expected orthonormal rows to 1e-4"},
        {edited(rotation, "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]"),
         "key 'sensor[0].rotation': expected a rotation, found a reflection"},
        {edited("translation = [0, 0.5, 1]", "translation = [0, 0.5]"),
         "key 'sensor[0].translation': expected three finite numbers"},
        {edited("translation = [0, 0.5, 1]", "translation = [0, 0, 1e9]"),
         "key 'sensor[0].translation': expected metres"},
        {edited("\"freenect://0\"", "5"), "key 'sensor[0].uri': expected the device's URI, found 5"},
        {edited("min = [-2.0, -1.5, 0]", ""), "key 'cell.min': expected three finite numbers, found nothing"},
        {edited("max = [2.0, 1.5, 2.2]", "max = [2.0, -1.5, 2.2]"),
         "key 'cell.max': expected each number above that of cell.min"},
        {edited("max = [2.0, 1.5, 2.2]", "max = [2.0, 1.5, 2e9]"),
         "key 'cell.max': expected a cell within 1000 m"},
        {edited("max = [2.0, 1.5, 2.2]", "max = " + nines.substr(0, 5) + "]"),
         "key 'cell.max': expected three finite numbers"},
        {edited("pointing_axis = [0, 2, 0]", "pointing_axis = [0, 0, 0]"),
         "key 'cell.pointing_axis': expected a direction, not the zero vector"},
        {edited("[cell]", "cell = 5\n[other]"), "key 'cell': expected a table headed [cell], found 5"},
    };
}

TEST(CalibrationFile, RefusesEachBadFileByKey) {
    for (const BadFile& bad : bad_files()) {
        const auto file = parse_calibration(bad.text, "cell/calibration.toml");
        ASSERT_FALSE(file) << bad.sentence;
        EXPECT_THAT(file.error().sentence, HasSubstr(bad.sentence));
        EXPECT_EQ(file.error().sentence.rfind("cell/calibration.toml: ", 0), 0U) << file.error().sentence;
        EXPECT_EQ(file.error().sentence.find('\n'), std::string::npos);
        EXPECT_LT(file.error().sentence.size(), 400U);
    }
}

TEST(CalibrationFile, ARotationRoundedToFourDigitsPasses) {
    const auto file = parse_calibration(
        edited("[[1, 0, 0], [0, 0, 1], [0, -1, 0]]", "[[0.86603, 0.5, 0], [-0.5, 0.86603, 0], [0, 0, 1]]"),
        "c.toml");
    ASSERT_TRUE(file) << file.error().sentence;
    EXPECT_EQ(file->rig.sensors[0].camera_from_world.rotation(0, 0), 0.86603) << "values are not touched";
}

TEST(CalibrationFile, UnknownKeysAreWarnings) {
    const auto file = parse_calibration(
        edited("width = 640", "colour = 3\n\"two\\nlines\" = 1\nwidth = 640") + "gain = 1\n", "c.toml");
    ASSERT_TRUE(file) << file.error().sentence;
    EXPECT_THAT(file->warnings, ::testing::ElementsAre("c.toml: unknown key 'sensor[0].colour' is ignored",
                                                       "c.toml: unknown key 'sensor[0].two lines' is ignored",
                                                       "c.toml: unknown key 'sensor[1].gain' is ignored"));
}

TEST(CalibrationFile, RefusesWhatIsNoFile) {
    EXPECT_THAT(read_calibration("/none/calibration.toml").error().sentence,
                HasSubstr("/none/calibration.toml: cannot be opened: No such file or directory"));
    EXPECT_THAT(read_calibration(::testing::TempDir()).error().sentence,
                HasSubstr("expected a regular file"));
    EXPECT_THAT(read_calibration("/dev/zero").error().sentence,
                HasSubstr("/dev/zero: expected a regular file"));
    const fs::path large = temporary("large.toml");
    std::ofstream(large) << std::string(2 << 20, '#');
    EXPECT_THAT(read_calibration(large).error().sentence, HasSubstr("expected at most 1048576 bytes"));
    fs::remove(large);
}

TEST(CalibrationFile, DoesNotWriteWhatCouldNotBeRead) {
    const auto file = parse_calibration(good, "c.toml");
    SensorRig rig = file->rig;
    rig.sensors[1].name = "left";
    const fs::path path = temporary("unwritten.toml");
    EXPECT_THAT(write_calibration(rig, path).error().sentence, HasSubstr("a name that no other sensor has"));
    rig = file->rig;
    rig.sensors[0].camera.fx = std::nan("");
    EXPECT_THAT(write_calibration(rig, path).error().sentence, HasSubstr("key 'sensor[0].fx'"));
    EXPECT_FALSE(fs::exists(path));
    EXPECT_THAT(write_calibration(file->rig, "/none/c.toml").error().sentence,
                HasSubstr("/none/c.toml: cannot be written"));
}

TEST(CalibrationFile, DamagedTextNeverCrashes) {
    std::mt19937 random(6);
    int refused = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        std::string text = good;
        for (auto n = 1 + random() % 4; n > 0; --n)
            text[random() % text.size()] = static_cast<char>(random());
        if (trial % 3 == 0) text.resize(random() % text.size());
        const auto file = parse_calibration(text, "c.toml");
        if (file) continue;
        ++refused;
        ASSERT_EQ(file.error().sentence.rfind("c.toml: ", 0), 0U);
    }
    EXPECT_GT(refused, 1000);
}

TEST(TomlFloat, ReadsBackToTheBit) {
    for (const double value :
         {0.0, -0.0, 1.0, -3.0, 0.1, 1e300, 5e-324, 1e22, 123456789012345680.0, 2.0 / 3.0}) {
        const auto table = parse_toml("x = " + toml_float(value), "t");
        ASSERT_TRUE(table) << toml_float(value);
        ASSERT_TRUE(table->get("x")->is_floating_point()) << toml_float(value);
        const double back = table->get("x")->as_floating_point()->get();
        EXPECT_EQ(std::memcmp(&back, &value, sizeof value), 0) << toml_float(value);
    }
}

TEST(UtcTime, KnowsTimesFromOtherText) {
    for (const char* text : {"2026-11-22T10:00:00Z", "2026-11-22T23:59:60Z", "1999-01-01T00:00:00.123456Z"})
        EXPECT_TRUE(is_utc_time(text)) << text;
    for (const char* text :
         {"", "Z", "2026-11-22", "2026-11-22 10:00:00Z", "2026-11-22T10:00:00", "2026-11-22T10:00:00+01:00",
          "2026-00-22T10:00:00Z", "2026-11-32T10:00:00Z", "2026-11-22T24:00:00Z", "2026-11-22T10:00:00.Z",
          "2026-11-22T10:00:00,5Z", "2026-11-22T10:0a:00Z"})
        EXPECT_FALSE(is_utc_time(text)) << text;
}

}  // namespace
}  // namespace deixis
