// Session folders: written, opened, refused, mended.
#include "appliance/sessions/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <random>

#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/session_writer.h"
#include "tests/appliance/sessions/session_samples.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using namespace testing;  // NOLINT: our own helpers

#define ASSERT_OK(expression)                               \
    do {                                                    \
        const auto& ok = (expression);                      \
        ASSERT_TRUE(ok.has_value()) << ok.error().sentence; \
    } while (false)

std::string failure_of(const fs::path& folder) {
    const auto session = open_session(folder);
    return session ? "opened" : session.error().sentence;
}

/// Three left and two right frames, background of the left sensor, a part, truth, settings.
void write_sample_session(const ScratchFolder& scratch, const fs::path& folder) {
    auto writer = SessionWriter::create(folder, sample_rig(), sample_origin());
    ASSERT_OK(writer);
    for (int i = 0; i < 3; ++i)
        ASSERT_OK(
            writer->append(0, 5'000'000 + 33'000 * i, room_image(24, 16, static_cast<uint32_t>(i)), 77 + i));
    for (int i = 0; i < 2; ++i)
        ASSERT_OK(writer->append(1, -400 + 33'000 * i, room_image(33, 17, static_cast<uint32_t>(i))));
    ASSERT_OK(writer->set_background(0, room_image(24, 16, 9)));
    fs::create_directories(scratch / "parts/cad");
    write_bytes(scratch / "parts/cad/bumper.stl", "solid");
    write_bytes(
        scratch / "parts/part.toml",
        "# ours\ntype = \"bumper\"\nserial = \"1\"\nmodel = \"cad/bumper.stl\"\nunits = \"mm\"\n[[zones]]\n"
        "name = \"all\"\nmin = [-0.1, 0.123456789012345678, 1e-7]\nmax = [1, 1, 1]\n");
    ASSERT_OK(writer->copy_part(scratch / "parts/part.toml"));
    ASSERT_OK(writer->add_truth_line(R"({"timestamp_us": 1})"));
    ASSERT_OK(writer->add_truth_line(R"({"timestamp_us": 2})"));
    ASSERT_OK(writer->set_settings("[carving]\nvoxel_m = 0.03\n"));
    ASSERT_FALSE(fs::exists(folder)) << "nothing stands there before it is whole";
    ASSERT_OK(writer->finish());
    ASSERT_FALSE(fs::exists(folder.string() + ".recording"));
}

TEST(Session, WritesAndOpens) {
    const ScratchFolder scratch;
    write_sample_session(scratch, scratch / "s");
    const auto session = open_session(scratch / "s");
    ASSERT_OK(session);
    EXPECT_EQ(session->name, "a test");
    EXPECT_EQ(session->created, "2026-11-22T10:00:00Z");
    EXPECT_TRUE(session->warnings.empty());
    ASSERT_EQ(session->streams.size(), 2U);
    EXPECT_EQ(session->streams[0].sensor, "left");
    EXPECT_EQ(session->streams[0].start_us, 5'000'000);
    EXPECT_EQ(session->streams[0].frames, 3);
    EXPECT_TRUE(session->streams[0].file.is_absolute());
    EXPECT_EQ(session->streams[1].start_us, -400);
    EXPECT_EQ(session->streams[1].frames, 2);
    std::vector<int64_t> stamps;
    ASSERT_OK(read_oni(session->streams[1].file, [&](int64_t frame, int64_t stamp, const DepthImage& image) {
        stamps.push_back(session->streams[1].start_us + stamp);
        EXPECT_EQ(image.millimetres, room_image(33, 17, static_cast<uint32_t>(frame)).millimetres);
        return true;
    }));
    EXPECT_THAT(stamps, ElementsAre(-400, 32'600));
    const auto host = read_host_times(session->streams[0]);
    ASSERT_OK(host);
    EXPECT_THAT(*host, ElementsAre(77, 78, 79));
    EXPECT_TRUE(read_host_times(session->streams[1])->empty());
    const auto background = read_background(*session);
    ASSERT_OK(background);
    ASSERT_EQ(background->size(), 2U);
    EXPECT_EQ((*background)[0]->millimetres, room_image(24, 16, 9).millimetres);
    EXPECT_FALSE((*background)[1]);
    EXPECT_EQ(bytes_of(*session->truth), "{\"timestamp_us\": 1}\n{\"timestamp_us\": 2}\n");
    EXPECT_EQ(bytes_of(*session->settings), "[carving]\nvoxel_m = 0.03\n");
    EXPECT_FALSE(session->expected);
    EXPECT_EQ(bytes_of(scratch / "s/bumper.stl"), "solid");
    const std::string part = bytes_of(*session->part);
    EXPECT_THAT(part,
                ::testing::AnyOf(HasSubstr("model = 'bumper.stl'"), HasSubstr("model = \"bumper.stl\"")));
    EXPECT_THAT(part, HasSubstr("0.12345678901234568"));
}

TEST(Session, APartFileWhoseModelLiesBesideItIsCopiedUnchanged) {
    const ScratchFolder scratch;
    const std::string text = "# ours\ntype = \"a\"\nmodel = \"b.stl\" # beside\n";
    write_bytes(scratch / "b.stl", "solid");
    write_bytes(scratch / "part.toml", text);
    auto writer = SessionWriter::create(scratch / "s", sample_rig(), sample_origin());
    ASSERT_OK(writer->copy_part(scratch / "part.toml"));
    ASSERT_OK(writer->finish());
    EXPECT_EQ(bytes_of(scratch / "s/part.toml"), text);
}

TEST(Session, HoldsInfraredAndVideo) {
    const ScratchFolder scratch;
    SensorRig rig;
    rig.sensors.push_back(sample_sensor("ir", SensorKind::infrared, 16, 12));
    rig.sensors.push_back(sample_sensor("film", SensorKind::video, 8, 4));
    auto writer = SessionWriter::create(scratch / "s", rig, sample_origin());
    ASSERT_OK(writer);
    ASSERT_OK(writer->append(0, 100, noise_image(16, 12, 1, 65535)));
    const VideoImage rgb{8, 4, 3, std::vector<uint8_t>(96, 17)};
    ASSERT_OK(writer->append(1, 90, rgb));
    ASSERT_OK(writer->append(1, 95, VideoImage{8, 4, 1, std::vector<uint8_t>(32, 255)}));
    EXPECT_THAT(writer->append(1, 99, noise_image(8, 4, 1, 9)).error().sentence,
                HasSubstr("expected an 8 bit image"));
    EXPECT_THAT(writer->append(0, 199, rgb).error().sentence, HasSubstr("expected a 16 bit image"));
    EXPECT_THAT(writer->append(1, 99, VideoImage{8, 4, 2, {}}).error().sentence,
                HasSubstr("one or three channels"));
    EXPECT_THAT(writer->set_background(0, noise_image(16, 12, 1, 9)).error().sentence,
                HasSubstr("expected a depth sensor"));
    ASSERT_OK(writer->finish());
    const auto session = open_session(scratch / "s");
    ASSERT_OK(session);
    const auto video = open_video_stream(session->streams[1]);
    ASSERT_OK(video);
    EXPECT_THAT(video->timestamp_us, ElementsAre(90, 95));
    EXPECT_EQ(session->streams[1].start_us, 0);
    EXPECT_TRUE(read_host_times(session->streams[1])->empty());
    EXPECT_EQ(read_video_png(video->files[0], {8, 4})->bytes, rgb.bytes);
    write_bytes(scratch / "s/film/000001.png", "damaged");
    EXPECT_THAT(failure_of(scratch / "s"), HasSubstr("film is not what was recorded"));
    fs::remove(scratch / "s/film/000001.png");
    EXPECT_THAT(failure_of(scratch / "s"), HasSubstr("000001.png: expected the image of frame 1"));
}

TEST(SessionWriter, RefusesByNameAndGoesOn) {
    const ScratchFolder scratch;
    auto writer = SessionWriter::create(scratch / "s", sample_rig(), sample_origin());
    ASSERT_OK(writer);
    ASSERT_OK(writer->append(0, 100, room_image(24, 16, 1)));
    EXPECT_THAT(writer->append(0, 100, room_image(24, 16, 1)).error().sentence,
                HasSubstr("left.oni: frame 1: expected a timestamp above 100, found 100"));
    EXPECT_THAT(writer->append(0, 200, room_image(33, 17, 1)).error().sentence,
                HasSubstr("expected 24 x 16 pixels"));
    EXPECT_THAT(writer->append(0, 200, flat_image(24, 16, 65535)).error().sentence, HasSubstr("found 65535"));
    EXPECT_THAT(writer->append(2, 200, flat_image(24, 16, 1)).error().sentence,
                HasSubstr("expected a sensor below 2"));
    EXPECT_THAT(writer->append(0, INT64_MAX, flat_image(24, 16, 1)).error().sentence,
                HasSubstr("within 2^61"));
    EXPECT_THAT(writer->set_background(0, flat_image(24, 16, 65535)).error().sentence,
                HasSubstr("left.png: expected 0 to 65534"));
    EXPECT_THAT(writer->set_background(0, flat_image(4, 4, 1)).error().sentence,
                HasSubstr("expected 24 x 16 pixels"));
    EXPECT_THAT(writer->add_truth_line("no object").error().sentence,
                HasSubstr("expected one JSON object on one line"));
    EXPECT_THAT(writer->add_truth_line("{\n}").error().sentence,
                HasSubstr("expected one JSON object on one line"));
    EXPECT_THAT(writer->copy_truth(scratch / "none").error().sentence, HasSubstr("none: cannot be copied"));
    EXPECT_THAT(writer->copy_part(scratch / "none.toml").error().sentence,
                HasSubstr("none.toml: cannot be opened"));
    write_bytes(scratch / "part.toml", "model = 5");
    EXPECT_THAT(writer->copy_part(scratch / "part.toml").error().sentence,
                HasSubstr("key 'model': expected the name of the model file, found 5"));
    write_bytes(scratch / "part.toml", "model = \"gone.stl\"");
    EXPECT_THAT(writer->copy_part(scratch / "part.toml").error().sentence,
                HasSubstr("expected a model file, found nothing"));
    write_bytes(scratch / "left.oni", "not a model");
    write_bytes(scratch / "part.toml", "model = \"left.oni\"");
    EXPECT_THAT(writer->copy_part(scratch / "part.toml").error().sentence,
                HasSubstr("expected another file name than left.oni"));
    EXPECT_THAT(writer->append(0, 200, room_image(24, 16, 2), 7).error().sentence,
                HasSubstr("left.oni: frame 1: expected no host_us, as frame 0 has none"));
    ASSERT_OK(writer->append(0, 200, room_image(24, 16, 2)));
    EXPECT_THAT(SessionWriter::create(scratch / "s", sample_rig(), sample_origin()).error().sentence,
                HasSubstr("s.recording: is an interrupted recording; mend or remove it first"));
    ASSERT_OK(writer->finish());
    EXPECT_EQ(open_session(scratch / "s")->streams[0].frames, 2);
    EXPECT_EQ(open_session(scratch / "s")->streams[1].frames, 0);
    EXPECT_THAT(writer->append(0, 300, room_image(24, 16, 2)).error().sentence, HasSubstr("is finished"));
    EXPECT_THAT(SessionWriter::create(scratch / "s", sample_rig(), sample_origin()).error().sentence,
                HasSubstr("s: exists already"));
    EXPECT_THAT(SessionWriter::create(scratch / "t", sample_rig(), {"n", "yesterday", {}}).error().sentence,
                HasSubstr("key 'created': expected a time like"));
    SensorRig large = sample_rig();
    large.sensors[1].camera.width = large.sensors[1].camera.height = 4000;
    EXPECT_THAT(SessionWriter::create(scratch / "t", large, sample_origin()).error().sentence,
                HasSubstr("right.oni: expected images of 1 to 2880000 pixels, found 4000 x 4000"));
    EXPECT_FALSE(fs::exists(scratch / "t.recording"));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

struct BadManifest {
    const char* sentence;
    std::function<std::string(std::string)> edit;
};

BadManifest swap(const char* sentence, const char* from, const char* to) {
    return {sentence, [=](const std::string& text) { return replaced(text, from, to); }};
}

TEST(Session, RefusesEachBadManifestByKey) {
    const ScratchFolder scratch;
    write_sample_session(scratch, scratch / "s");
    const std::string good = bytes_of(scratch / "s/session.toml");
    const std::vector<BadManifest> bad = {
        {"key 'format': expected \"deixis-session/1\", found nothing", [](const std::string&) { return ""; }},
        {"line 1, column", [](const std::string&) { return "format = "; }},
        {"expected TOML", [](const std::string&) { return std::string("\0\x01\xFF", 3); }},
        {"expected TOML",
         [](const std::string& text) { return text + "\nname = \"twice\"\nname = \"twice\""; }},
        {"expected TOML", [](const std::string&) { return "a = " + std::string(5000, '['); }},
        {"session.toml: expected at most 1048576 bytes",
         [](const std::string& t) { return t + std::string(2 << 20, '#'); }},
        swap("key 'format': expected \"deixis-session/1\", found \"deixis-session/2\"", "session/1",
             "session/2"),
        swap("key 'name': expected the session's name, found 7", "\"a test\"", "7"),
        swap("key 'created': expected a time like", "2026-11-22T10:00:00Z", "22.11.2026"),
        swap("key 'created': expected a time like", "2026-11-22T10:00:00Z", "2026-13-22T10:00:00Z"),
        swap("key 'tools': expected a table", "[tools]\n\"deixis\" = \"0.1.0\"", "tools = 3"),
        swap("key 'tools.deixis': expected a version in quotes", "\"0.1.0\"", "0.1"),
        swap("key 'stream[0].sensor': expected the name of a sensor in calibration.toml, found nothing",
             "sensor = \"left\"\n", ""),
        swap("key 'stream[0].sensor': expected a sensor of calibration.toml, found \"top\"",
             "sensor = \"left\"", "sensor = \"top\""),
        swap("key 'stream[1].sensor': expected a sensor that has no stream yet, found \"left\"",
             "sensor = \"right\"", "sensor = \"left\""),
        swap("key 'stream[0].file': expected the name of a file in the session folder, found \"../left.oni\"",
             "\"left.oni\"", "\"../left.oni\""),
        swap("key 'stream[0].file': expected the name of a file in the session folder, found \"/etc/passwd\"",
             "\"left.oni\"", "\"/etc/passwd\""),
        swap("key 'stream[0].file': expected the name of a file in the session folder", "\"left.oni\"",
             "\"left\\u0000.oni\""),
        swap("key 'stream[0].file': expected the name of a file in the session folder", "\"left.oni\"",
             "\"..\""),
        swap("key 'stream[0].file': expected the name of a file in the session folder", "\"left.oni\"",
             "\"left\\n.oni\""),
        swap("key 'stream[0].sensor': expected a sensor of calibration.toml, found \"l\\u000Aeft\"",
             "sensor = \"left\"", "sensor = \"l\\neft\""),
        swap("session.toml: line 2, column", "\"a test\"", "t"),
        swap("key 'tools.a b': expected a version in quotes", "\"deixis\" = \"0.1.0\"", "\"a\\nb\" = 1"),
        swap("key 'stream[0].file': expected a recording at", "\"left.oni\"", "\"gone.oni\""),
        swap("key 'stream[0].file': expected a recording at", "\"left.oni\"", "\"background\""),
        swap("right.oni: expected 24 x 16 pixels as in calibration.toml, found 33 x 17", "\"left.oni\"",
             "\"right.oni\""),
        swap("key 'stream[0].start_us': expected a whole number from", "start_us = 5000000",
             "start_us = 0.5"),
        swap("key 'stream[0].start_us': expected a whole number from", "start_us = 5000000",
             "start_us = 9223372036854775807"),
        swap("key 'stream[0].frames': expected 3 as in left.oni, found 4", "frames = 3", "frames = 4"),
        swap("key 'stream[0].frames': expected a whole number from 0", "frames = 3", "frames = -1"),
        swap("key 'stream[0].checksum': expected \"xxh3-64:\" and 16 hexadecimal digits", "xxh3-64:", "md5:"),
        swap("key 'stream[0].host_times': expected a file at", "\"left.csv\"", "\"gone.csv\""),
        {"key 'stream': expected a stream of sensor 'right', which calibration.toml names",
         [](const std::string& text) { return text.substr(0, text.rfind("[[stream]]")); }},
        {"key 'stream': expected 1 to 64 tables",
         [](const std::string& text) { return text.substr(0, text.find("[[stream]]")); }},
        {"key 'stream': expected tables headed [[stream]], found 5",
         [](const std::string& text) { return "stream = 5\n" + text.substr(0, text.find("[[stream]]")); }},
    };
    for (const BadManifest& b : bad) {
        write_bytes(scratch / "s/session.toml", b.edit(good));
        EXPECT_THAT(failure_of(scratch / "s"), HasSubstr(b.sentence));
        EXPECT_EQ(failure_of(scratch / "s").find('\n'), std::string::npos);
        EXPECT_THAT(failure_of(scratch / "s"), HasSubstr(scratch.path().string())) << "names the file";
    }
    write_bytes(scratch / "s/session.toml", good);
    EXPECT_EQ(failure_of(scratch / "s"), "opened");
}

TEST(Session, UnknownKeysAreWarningsAndStreamsMayStandInAnyOrder) {
    const ScratchFolder scratch;
    write_sample_session(scratch, scratch / "s");
    const std::string text = bytes_of(scratch / "s/session.toml");
    const size_t first = text.find("[[stream]]");
    const size_t second = text.rfind("[[stream]]");
    write_bytes(scratch / "s/session.toml", "colour = 1\n" + text.substr(0, first) + text.substr(second) +
                                                "lens = 2\n" + text.substr(first, second - first));
    const auto session = open_session(scratch / "s");
    ASSERT_OK(session);
    EXPECT_EQ(session->streams[0].sensor, "left");
    ASSERT_EQ(session->warnings.size(), 2U);
    EXPECT_THAT(session->warnings[0], HasSubstr("session.toml: unknown key 'stream[0].lens' is ignored"));
    EXPECT_THAT(session->warnings[1], HasSubstr("session.toml: unknown key 'colour' is ignored"));
}

TEST(Session, ATomlDateTimeIsATimeToo) {
    const auto session = parse_session(
        "format = \"deixis-session/1\"\nname = \"a\"\ncreated = 2026-11-22T10:00:00Z\n"
        "[[stream]]\nsensor = \"l\"\nfile = \"l.oni\"\nstart_us = 0\nframes = 1\n"
        "checksum = \"xxh3-64:0123456789abcdef\"\n",
        "s");
    ASSERT_OK(session);
    EXPECT_EQ(session->created, "2026-11-22T10:00:00Z");
}

TEST(Session, RefusesChangedAndMissingFiles) {
    const ScratchFolder scratch;
    write_sample_session(scratch, scratch / "s");
    EXPECT_THAT(failure_of(scratch / "none"), HasSubstr("none: expected a session folder"));
    const std::string left = bytes_of(scratch / "s/left.oni");
    std::string changed = left;
    changed[changed.size() / 2] ^= 1;
    write_bytes(scratch / "s/left.oni", changed);
    EXPECT_THAT(failure_of(scratch / "s"), HasSubstr("left.oni is not what was recorded"));
    EXPECT_TRUE(open_session(scratch / "s", false));
    write_bytes(scratch / "s/left.oni", "short");
    EXPECT_THAT(failure_of(scratch / "s"), HasSubstr("left.oni: byte 5: expected the 24 bytes"));
    fs::remove(scratch / "s/left.oni");
    EXPECT_THAT(failure_of(scratch / "s"), HasSubstr("expected a recording at"));
    write_bytes(scratch / "s/left.oni", left);
    write_bytes(scratch / "s/background/left.png", "damaged");
    EXPECT_THAT(read_background(*open_session(scratch / "s")).error().sentence,
                HasSubstr("left.png: byte 0: expected a PNG"));
    write_bytes(scratch / "s/left.csv", "frame,timestamp_us,host_us\n0,1,2\n");
    EXPECT_THAT(read_host_times(open_session(scratch / "s")->streams[0]).error().sentence,
                HasSubstr("left.csv: expected a host_us for each of 3 frames, found 1"));
    fs::remove(scratch / "s/calibration.toml");
    EXPECT_THAT(failure_of(scratch / "s"), HasSubstr("calibration.toml: cannot be opened"));
    fs::remove(scratch / "s/session.toml");
    EXPECT_THAT(failure_of(scratch / "s"), HasSubstr("session.toml: cannot be opened"));
}

/// The writer dies in a child process after `frames` frames; what it leaves is no session, and then one.
void check_mending_after_kill(int frames) {
    const ScratchFolder scratch;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        SensorRig rig = sample_rig();
        rig.sensors.push_back(sample_sensor("film", SensorKind::video, 8, 4));
        auto writer = SessionWriter::create(scratch / "s", rig, sample_origin());
        if (!writer) ::_exit(1);
        for (int i = 0; i < frames; ++i) {
            const auto seed = static_cast<uint32_t>(i);
            if (!writer->append(0, 1000 + i, room_image(24, 16, seed), 50 + i)) ::_exit(2);
            if (!writer->append(1, 2000 + i, room_image(33, 17, seed))) ::_exit(3);
            if (!writer->append(2, 3000 + i, VideoImage{8, 4, 1, std::vector<uint8_t>(32, 255)}, 70 + i))
                ::_exit(4);
            if (!writer->add_truth_line("{\"timestamp_us\": 1}")) ::_exit(5);
        }
        ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << WEXITSTATUS(status);
    EXPECT_THAT(failure_of(scratch / "s.recording"),
                HasSubstr("this recording was interrupted and can be mended"));
    // As if the last writes had been torn as well.
    if (frames > 0) {
        fs::resize_file(scratch / "s.recording/left.oni",
                        fs::file_size(scratch / "s.recording/left.oni") - 3);
        write_bytes(scratch / "s.recording/truth.jsonl",
                    bytes_of(scratch / "s.recording/truth.jsonl") + "{\"time");
        write_bytes(scratch / "s.recording/film/timestamps.csv",
                    bytes_of(scratch / "s.recording/film/timestamps.csv") + std::to_string(frames) + ",30");
        write_bytes(scratch / ("s.recording/film/00000" + std::to_string(frames) + ".png"), "\x89PNG");
    }
    const auto mended = mend_session(scratch / "s.recording/");
    ASSERT_OK(mended);
    EXPECT_EQ(*mended, scratch / "s");
    const auto session = open_session(scratch / "s");
    ASSERT_OK(session);
    EXPECT_EQ(session->name, "a test");
    EXPECT_EQ(session->streams[0].frames, std::max(0, frames - 1));
    EXPECT_EQ(session->streams[1].frames, frames);
    EXPECT_EQ(session->streams[2].frames, frames);
    if (frames == 0) return;
    EXPECT_EQ(session->streams[0].start_us, 1000);
    EXPECT_EQ(session->streams[1].start_us, 2000);
    EXPECT_EQ(read_host_times(session->streams[0])->size(), static_cast<size_t>(frames - 1));
    EXPECT_EQ(read_host_times(session->streams[2])->size(), static_cast<size_t>(frames));
    EXPECT_EQ(read_host_times(session->streams[2])->back(), 70 + frames - 1);
    EXPECT_EQ(bytes_of(*session->truth).size(), static_cast<size_t>(frames) * 20);
    EXPECT_FALSE(fs::exists(scratch / "s/recording.toml"));
}

TEST(MendSession, MakesASessionOfWhatAKilledWriterLeft) {
    check_mending_after_kill(4);
    check_mending_after_kill(1);
    check_mending_after_kill(0);
}

TEST(MendSession, RefusesWhatIsNoInterruptedRecording) {
    const ScratchFolder scratch;
    EXPECT_THAT(mend_session(scratch / "s").error().sentence,
                HasSubstr("expected a folder whose name ends in .recording"));
    EXPECT_THAT(mend_session(scratch / "s.recording").error().sentence,
                HasSubstr("recording.toml: cannot be opened"));
    fs::create_directory(scratch / "s.recording");
    write_bytes(scratch / "s.recording/recording.toml", "format = \"deixis-session/1\"");
    EXPECT_THAT(mend_session(scratch / "s.recording").error().sentence,
                HasSubstr("expected \"deixis-recording/1\""));
}

TEST(Session, ManifestTextThatIsDamagedNeverCrashes) {
    const ScratchFolder scratch;
    write_sample_session(scratch, scratch / "s");
    const std::string good = bytes_of(scratch / "s/session.toml");
    std::mt19937 random(4);
    int refused = 0;
    for (int trial = 0; trial < 3000; ++trial) {
        std::string text = good;
        for (auto n = 1 + random() % 4; n > 0; --n)
            text[random() % text.size()] = static_cast<char>(random());
        if (trial % 3 == 0) text.resize(random() % text.size());
        const auto parsed = parse_session(text, "s.toml");
        if (parsed) continue;
        ++refused;
        ASSERT_THAT(parsed.error().sentence, HasSubstr("s.toml: "));
    }
    EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace deixis
