// Frames folders from anywhere: imported whole, or refused in one sentence with nothing left behind.
#include "appliance/sessions/import_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <random>

#include "appliance/sessions/session.h"
#include "tests/appliance/sessions/imported_frames.h"
#include "tests/appliance/sessions/session_samples.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace testing;  // NOLINT: our own helpers

TEST(ImportFrames, SensorsOfDifferentSizeAndLength) {
    const ScratchFolder scratch;
    SensorRig rig = sample_rig();
    rig.sensors.push_back(sample_sensor("hd", SensorKind::depth, 1280, 720));
    rig.sensors.push_back(sample_sensor("kinect 2", SensorKind::depth, 512, 424));
    write_frames_folder(scratch / "frames", rig, {5, 3, 1, 2});
    const auto report = import_frames(scratch / "frames", scratch / "out", sample_origin());
    ASSERT_TRUE(report) << report.error().sentence;
    EXPECT_THAT(report->frames, ElementsAre(5, 3, 1, 2));
    EXPECT_THAT(report->warnings, IsEmpty());
    const auto session = open_session(scratch / "out");
    ASSERT_TRUE(session) << session.error().sentence;
    expect_same_frames(*session, scratch / "frames");
    EXPECT_EQ(bytes_of(scratch / "out/calibration.toml"), bytes_of(scratch / "frames/calibration.toml"));
}

TEST(ImportFrames, NamesBeyondAsciiReadBack) {
    const ScratchFolder scratch;
    SensorRig rig;
    rig.sensors.push_back(sample_sensor("T\xC3\xBCr", SensorKind::depth, 24, 16));
    write_frames_folder(scratch / "frames", rig, {2});
    ASSERT_TRUE(import_frames(scratch / "frames", scratch / "out", sample_origin()));
    const auto session = open_session(scratch / "out");
    ASSERT_TRUE(session) << session.error().sentence;
    EXPECT_EQ(session->streams[0].sensor, "T\xC3\xBCr");
    EXPECT_TRUE(walk_oni(session->streams[0].file));
}

TEST(ImportFrames, SideFilesComeAlong) {
    const ScratchFolder scratch;
    write_frames_folder(scratch / "frames", sample_rig(), {2, 2});
    fs::create_directories(scratch / "frames/background");
    fs::create_directories(scratch / "frames/stray");
    ASSERT_TRUE(write_depth_png(room_image(33, 17, 5), scratch / "frames/background/right.png"));
    write_bytes(scratch / "bumper.step", "ISO-10303-21;");
    write_bytes(scratch / "frames/part.toml",
                "type = \"x\"\nserial = \"2\"\nmodel = \"../bumper.step\"\nunits = \"mm\"\n");
    write_bytes(
        scratch / "frames/truth.jsonl",
        "\xEF\xBB\xBF{\"timestamp_us\": 1000000, \"joints\": null}\r\n\r\n{\"timestamp_us\": 1040000}");
    write_bytes(scratch / "frames/expected.toml", "marks_found_min = 1.0\n");
    write_bytes(scratch / "frames/settings.toml", "[pointing]\ndwell_s = 1.0\n");
    write_bytes(scratch / "frames/left/notes.txt", "cloudy");
    const auto report = import_frames(scratch / "frames", scratch / "out", {"", "2026-11-22T10:00:00Z", {}});
    ASSERT_TRUE(report) << report.error().sentence;
    ASSERT_EQ(report->warnings.size(), 2U);
    EXPECT_THAT(report->warnings[0], HasSubstr("stray: is left out, being no sensor of calibration.toml"));
    EXPECT_THAT(report->warnings[1], HasSubstr("notes.txt: is left out"));
    const auto session = open_session(scratch / "out");
    ASSERT_TRUE(session) << session.error().sentence;
    EXPECT_EQ(session->name, "frames");
    EXPECT_TRUE(session->part && session->truth && session->expected && session->settings);
    EXPECT_EQ(bytes_of(scratch / "out/bumper.step"), "ISO-10303-21;");
    EXPECT_THAT(bytes_of(*session->part), HasSubstr("bumper.step"));
    EXPECT_THAT(bytes_of(*session->part), ::testing::Not(HasSubstr("../")));
    EXPECT_EQ((*read_background(*session))[1]->millimetres, room_image(33, 17, 5).millimetres);
}

TEST(ImportFrames, InfraredVideoAndHostTimes) {
    const ScratchFolder scratch;
    SensorRig rig;
    rig.sensors.push_back(sample_sensor("ir8", SensorKind::infrared, 16, 12));
    rig.sensors.push_back(sample_sensor("film", SensorKind::video, 8, 4));
    rig.sensors.push_back(sample_sensor("depth", SensorKind::depth, 8, 4));
    write_frames_folder(scratch / "frames", rig, {1, 1, 2});
    const VideoImage grey{16, 12, 1, std::vector<uint8_t>(192, 200)};
    const VideoImage rgb{8, 4, 3, std::vector<uint8_t>(96, 9)};
    ASSERT_TRUE(write_video_png(grey, scratch / "frames/ir8/000000.png"));
    ASSERT_TRUE(write_video_png(rgb, scratch / "frames/film/000000.png"));
    write_bytes(scratch / "frames/depth/timestamps.csv",
                "\xEF\xBB\xBF"
                "frame, timestamp_us, host_us\r\n0, -5, 100\r\n1, 0, 90\r\n\r\n");
    const auto report = import_frames(scratch / "frames", scratch / "out", sample_origin());
    ASSERT_TRUE(report) << report.error().sentence;
    const auto session = open_session(scratch / "out");
    ASSERT_TRUE(session) << session.error().sentence;
    EXPECT_THAT(*read_host_times(session->streams[2]), ElementsAre(100, 90));
    EXPECT_EQ(session->streams[2].start_us, -5);
    EXPECT_EQ(read_video_png(open_video_stream(session->streams[1])->files[0], {8, 4})->bytes, rgb.bytes);
    ASSERT_TRUE(read_oni(session->streams[0].file, [](int64_t, int64_t, const DepthImage& image) {
        EXPECT_EQ(image.millimetres, std::vector<uint16_t>(192, 200));
        return true;
    }));
}

TEST(ImportFrames, KeepsTheHostsTimesOfEveryKindOfSensor) {
    const ScratchFolder scratch;
    SensorRig rig;
    rig.sensors.push_back(sample_sensor("depth", SensorKind::depth, 8, 4));
    rig.sensors.push_back(sample_sensor("ir", SensorKind::infrared, 8, 4));
    rig.sensors.push_back(sample_sensor("film", SensorKind::video, 8, 4));
    write_frames_folder(scratch / "frames", rig, {2, 2, 2});
    const std::string stamps = "frame,timestamp_us,host_us\n0,5,0\n1,6,-3\n";  // 0 is a time like any other
    for (const CalibratedSensor& sensor : rig.sensors)
        write_bytes(scratch / "frames" / sensor.name / "timestamps.csv", stamps);
    for (const char* image : {"film/000000.png", "film/000001.png"})
        ASSERT_TRUE(write_video_png({8, 4, 3, std::vector<uint8_t>(96, 9)}, scratch / "frames" / image));
    const auto report = import_frames(scratch / "frames", scratch / "out", sample_origin());
    ASSERT_TRUE(report) << report.error().sentence;
    const auto session = open_session(scratch / "out");
    ASSERT_TRUE(session) << session.error().sentence;
    for (const SessionStream& stream : session->streams) {
        const auto host = read_host_times(stream);
        ASSERT_TRUE(host) << host.error().sentence;
        EXPECT_THAT(*host, ElementsAre(0, -3)) << stream.sensor;
    }
    EXPECT_EQ(bytes_of(scratch / "out/film/timestamps.csv"), stamps);
    EXPECT_EQ(bytes_of(scratch / "out/depth.csv"), stamps);
}

struct BadFolder {
    const char* sentence;
    std::function<void(const fs::path&)> damage;
};

std::vector<BadFolder> bad_folders() {
    const auto put = [](const char* file, const std::string& text) {
        return [=](const fs::path& folder) { write_bytes(folder / file, text); };
    };
    const auto drop = [](const char* file) {
        return [=](const fs::path& folder) { fs::remove_all(folder / file); };
    };
    const std::string csv = "frame,timestamp_us\n";
    return {
        {"expected a frames folder", [](const fs::path& folder) { fs::remove_all(folder); }},
        {"calibration.toml: cannot be opened", drop("calibration.toml")},
        {"calibration.toml: key 'format': expected", put("calibration.toml", "")},
        {"right: expected a folder with the frames of sensor 'right'", drop("right")},
        {"right/timestamps.csv: cannot be opened", drop("right/timestamps.csv")},
        {"timestamps.csv: line 1: expected the header frame,timestamp_us", put("left/timestamps.csv", "")},
        {"timestamps.csv: line 1: expected the header", put("left/timestamps.csv", "0,1\n1,2\n2,3\n")},
        {"timestamps.csv: line 1: expected the header",
         put("left/timestamps.csv", "frame;timestamp_us\n0;1\n")},
        {"timestamps.csv: expected at least one frame", put("left/timestamps.csv", csv)},
        {"timestamps.csv: line 2: expected frame 0, found \"1\"", put("left/timestamps.csv", csv + "1,5\n")},
        {"timestamps.csv: line 3: expected frame 1, found \"2\"",
         put("left/timestamps.csv", csv + "0,5\n2,6\n")},
        {"timestamps.csv: line 3: expected a timestamp above 5, found \"5\"",
         put("left/timestamps.csv", csv + "0,5\n1,5\n")},
        {"timestamps.csv: line 3: expected a timestamp above 5, found \"4\"",
         put("left/timestamps.csv", csv + "0,5\n1,4\n")},
        {"timestamps.csv: line 2: expected a whole number of microseconds, found \"5.5\"",
         put("left/timestamps.csv", csv + "0,5.5\n")},
        {"timestamps.csv: line 2: expected a whole number",
         put("left/timestamps.csv", csv + "0,99999999999999999999\n")},
        {"timestamps.csv: line 2: expected two columns", put("left/timestamps.csv", csv + "0,5,6\n")},
        {"timestamps.csv: line 3: expected no empty line between frames",
         put("left/timestamps.csv", csv + "0,5\n\n1,6\n")},
        {"timestamps.csv: line 2: expected three columns",
         put("left/timestamps.csv", "frame,timestamp_us,host_us\n0,5\n")},
        {"timestamps.csv: line 2: expected a whole number of microseconds, found \"x\"",
         put("left/timestamps.csv", "frame,timestamp_us,host_us\n0,5,x\n")},
        {"left/000001.png: expected the image of frame 1, which timestamps.csv lists",
         drop("left/000001.png")},
        {"left/000003.png: expected the image of frame 3",
         put("left/timestamps.csv", csv + "0,1\n1,2\n2,3\n3,4\n")},
        {"timestamps.csv: expected a line for each of 3 images, found 2",
         put("left/timestamps.csv", csv + "0,1\n1,2\n")},
        {"timestamps.csv: expected a line for each of 4 images, found 3", put("left/000007.png", "x")},
        {"left/000002.png: byte 0: expected a PNG file", put("left/000002.png", "GIF89a")},
        {"left/000002.png: byte 0: expected a PNG file", put("left/000002.png", "")},
        {"left/000002.png: expected 24 x 16 pixels, found 33 x 17",
         [](const fs::path& f) {
             fs::copy_file(f / "right/000000.png", f / "left/000002.png",
                           fs::copy_options::overwrite_existing);
         }},
        {"left/000002.png: pixel (0, 0): expected 0 to 65534 mm, found 65535",
         [](const fs::path& f) {
             ASSERT_TRUE(write_depth_png(flat_image(24, 16, 65535), f / "left/000002.png"));
         }},
        {"left/000002.png: expected 16 bit grey, found 8 bit grey",
         [](const fs::path& f) {
             ASSERT_TRUE(write_video_png({24, 16, 1, std::vector<uint8_t>(384)}, f / "left/000002.png"));
         }},
        {"left/000002.png: expected 16 bit grey, found 8 bit RGB",
         [](const fs::path& f) {
             ASSERT_TRUE(write_video_png({24, 16, 3, std::vector<uint8_t>(1152)}, f / "left/000002.png"));
         }},
        {"background/left.png: byte 0: expected a PNG file",
         [](const fs::path& f) {
             fs::create_directory(f / "background");
             write_bytes(f / "background/left.png", "x");
         }},
        {"part.toml: line 1, column", put("part.toml", "model = ")},
        {"part.toml: key 'model': expected the name of the model file, found nothing",
         put("part.toml", "type = \"a\"")},
        {"part.toml: key 'model': expected a model file, found nothing at",
         put("part.toml", "model = \"none.stl\"")},
        {"part.toml: key 'model': expected a model file, found nothing at",
         put("part.toml", "model = \"left\"")},
        {"truth.jsonl: line 2: expected one JSON object", put("truth.jsonl", "{\"timestamp_us\": 1}\n[1]\n")},
        {"truth.jsonl: line 1: expected one JSON object", put("truth.jsonl", "{\"timestamp_us\": 1")},
        {"truth.jsonl: line 1: key 'timestamp_us': expected a whole number",
         put("truth.jsonl", "{\"timestamp_us\": 1.5}")},
        {"expected.toml: line 1, column", put("expected.toml", "=")},
        {"settings.toml: line 2, column", put("settings.toml", "a = 1\na = 2")},
    };
}

TEST(ImportFrames, RefusesEachBadFolderAndLeavesNothing) {
    for (const BadFolder& bad : bad_folders()) {
        const ScratchFolder scratch;
        write_frames_folder(scratch / "frames", sample_rig(), {3, 2});
        bad.damage(scratch / "frames");
        const auto report = import_frames(scratch / "frames", scratch / "out", sample_origin());
        ASSERT_FALSE(report) << bad.sentence;
        EXPECT_THAT(report.error().sentence, HasSubstr(bad.sentence));
        EXPECT_THAT(report.error().sentence, HasSubstr((scratch / "frames").string())) << "names the file";
        EXPECT_EQ(report.error().sentence.find('\n'), std::string::npos);
        EXPECT_FALSE(fs::exists(scratch / "out"));
        EXPECT_FALSE(fs::exists(scratch / "out.recording"));
    }
}

TEST(ImportFrames, RefusesAGreyVideoThatIsNoSilhouette) {
    const ScratchFolder scratch;
    SensorRig rig;
    rig.sensors.push_back(sample_sensor("film", SensorKind::video, 8, 4));
    write_frames_folder(scratch / "frames", rig, {1});
    VideoImage grey{8, 4, 1, std::vector<uint8_t>(32, 255)};
    grey.bytes[10] = 200;
    ASSERT_TRUE(write_video_png(grey, scratch / "frames/film/000000.png"));
    const auto report = import_frames(scratch / "frames", scratch / "out", sample_origin());
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().sentence, (scratch / "frames/film/000000.png").string() +
                                           ": pixel (2, 1): expected 0 or 255 of a silhouette, found 200");
    EXPECT_FALSE(fs::exists(scratch / "out"));
}

TEST(ImportFrames, KeepsAnExistingSession) {
    const ScratchFolder scratch;
    write_frames_folder(scratch / "frames", sample_rig(), {3, 2});
    ASSERT_TRUE(import_frames(scratch / "frames", scratch / "out", sample_origin()));
    const std::string before = bytes_of(scratch / "out/session.toml");
    EXPECT_THAT(import_frames(scratch / "frames", scratch / "out", sample_origin()).error().sentence,
                HasSubstr("out: exists already"));
    EXPECT_EQ(bytes_of(scratch / "out/session.toml"), before);
}

TEST(FrameStamps, WrittenTextReadsBack) {
    const FrameStamps plain{{-7, 0, int64_t{1} << 60}, {}};
    EXPECT_EQ(parse_timestamps(timestamps_text(plain), "t.csv")->timestamp_us, plain.timestamp_us);
    const FrameStamps both{{1, 2}, {9, 8}};
    EXPECT_EQ(parse_timestamps(timestamps_text(both), "t.csv")->host_us, both.host_us);
}

TEST(FrameStamps, RandomTextIsRefusedOrRises) {
    const std::string good = timestamps_text({{1, 20, 300, 4000}, {5, 6, 7, 8}});
    std::mt19937 random(8);
    for (int trial = 0; trial < 20'000; ++trial) {
        std::string text = good;
        for (auto n = 1 + random() % 3; n > 0; --n)
            text[random() % text.size()] = "0123456789,-\n\r \t"[random() % 16];
        const auto stamps = parse_timestamps(text, "t.csv");
        if (!stamps) {
            ASSERT_THAT(stamps.error().sentence, HasSubstr("t.csv: line "));
            continue;
        }
        ASSERT_TRUE(std::is_sorted(stamps->timestamp_us.begin(), stamps->timestamp_us.end()));
    }
}

}  // namespace
}  // namespace deixis
