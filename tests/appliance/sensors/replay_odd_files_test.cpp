// Recordings that are damaged, foreign or oddly named, through real `deixis sensor` processes: a sentence or
// every frame.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/appliance/sensors/replayed.h"

namespace deixis {
namespace {

using namespace test;
using testing::HasSubstr;

struct BadFile {
    const char* name;
    std::function<void(const std::filesystem::path&)> make;
    const char* sentence;
};

void cut_to(const std::filesystem::path& path, double share) {
    write_recording(path, steady_stamps(20));
    std::filesystem::resize_file(
        path, static_cast<uintmax_t>(static_cast<double>(std::filesystem::file_size(path)) * share));
}

void flip(const std::filesystem::path& path, size_t offset) {
    write_recording(path, steady_stamps(20));
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(offset));
    const char flipped = static_cast<char>(file.get() ^ 0x55);
    file.seekp(static_cast<std::streamoff>(offset));
    file.put(flipped);
}

const std::vector<BadFile>& bad_files() {
    static const std::vector<BadFile> cases = {
        {"missing", [](const auto&) {}, ": does not exist"},
        {"folder", [](const auto& p) { std::filesystem::create_directory(p); },
         ": is not a file, expected an OpenNI2"},
        {"fifo", [](const auto& p) { ASSERT_EQ(mkfifo(p.c_str(), 0600), 0); },
         ": is not a file, expected an OpenNI2"},
        {"device", [](const auto& p) { std::filesystem::create_symlink("/dev/null", p); },
         ": is not a file, expected an OpenNI2"},
        {"endless device", [](const auto& p) { std::filesystem::create_symlink("/dev/zero", p); },
         ": is not a file, expected an OpenNI2"},
        {"empty", [](const auto& p) { std::ofstream file(p); }, ": byte 0: expected"},
        {"text", [](const auto& p) { std::ofstream(p) << std::string(10'000, 'x'); }, ": byte 0: expected"},
        {"cut in the head", [](const auto& p) { cut_to(p, 0.001); }, ": byte "},
        {"cut in a frame", [](const auto& p) { cut_to(p, 0.5); }, ": "},
        {"cut before its end", [](const auto& p) { cut_to(p, 0.999); }, ": "},
        {"flipped version", [](const auto& p) { flip(p, 5); }, ": byte "},
        {"flipped node id", [](const auto& p) { flip(p, 20); }, ": byte "},
        {"flipped codec", [](const auto& p) { flip(p, 66); }, ": byte "},
        {"other size", [](const auto& p) { write_recording(p, steady_stamps(3), 0, 80, 60); },
         ": is 80x60, expected 160x120"},
        {"infrared",
         [](const auto& p) {
             auto writer = OniWriter::create(p, {stage_width, stage_height, 1.0, 0.8, true, 30});
             ASSERT_TRUE(writer && writer->append(0, numbered_image(stage_width, stage_height, 1)));
             ASSERT_TRUE(writer->finish());
         },
         ": is an infrared recording, expected depth"},
        {"not finished",
         [](const auto& p) {
             auto writer = OniWriter::create(p, {stage_width, stage_height, 1.0, 0.8, false, 30});
             for (uint32_t n = 1; n < 5; ++n)
                 ASSERT_TRUE(writer && writer->append(n, numbered_image(stage_width, stage_height, n)));
         },
         "mend"},
    };
    return cases;
}

TEST(ReplayOddFiles, BadFilesAreNamedAndGivenUpAtOnce) {
    ScratchFolder folder;
    for (const BadFile& c : bad_files()) {
        SCOPED_TRACE(c.name);
        const auto path = folder / (std::string(c.name) + ".oni");
        c.make(path);
        const Replayed replayed = replay(std::vector{recording_spec("left", path)});
        EXPECT_TRUE(replayed.ended);
        EXPECT_EQ(replayed.lines.size(), 0U);
        EXPECT_EQ(replayed.health[0].state, SensorState::missing);
        EXPECT_EQ(replayed.health[0].restarts, 0U);
        EXPECT_THAT(replayed.health[0].reason, HasSubstr(path.string()));
        EXPECT_THAT(replayed.health[0].reason, HasSubstr(c.sentence));
        EXPECT_EQ(replayed.health[0].reason.find('\n'), std::string::npos);
    }
}

TEST(ReplayOddFiles, AMissingSecondSensorLeavesItsFramesOut) {
    ScratchFolder folder;
    write_recording(folder / "left.oni", steady_stamps(12), 0);
    const Replayed replayed =
        replay({recording_spec("left", folder / "left.oni"), recording_spec("right", folder / "right.oni")});
    EXPECT_TRUE(replayed.ended);
    ASSERT_EQ(replayed.lines.size(), 12U);
    for (const auto& line : replayed.lines) EXPECT_FALSE(line.frames[1].has_value());
    EXPECT_EQ(replayed.health[1].state, SensorState::missing);
}

TEST(ReplayOddFiles, SparseTailOfTheStockRecorderIsNoDamage) {
    ScratchFolder folder;
    const auto path = folder / "left.oni";
    write_recording(path, steady_stamps(10), 0);
    std::filesystem::resize_file(path, 2 * std::filesystem::file_size(path));
    const Replayed replayed = replay(std::vector{recording_spec("left", path)});
    EXPECT_TRUE(replayed.ended);
    EXPECT_EQ(replayed.lines.size(), 10U) << replayed.health[0].reason;
    EXPECT_EQ(replayed.health[0].state, SensorState::finished);
}

TEST(ReplayOddFiles, PathWithBytesThatOpenniDiesOf) {
    ScratchFolder folder;
    const auto place = folder / "Aufnahmen für Müller #3 日本";
    std::filesystem::create_directories(place);
    write_recording(place / "Kamera links ü.oni", steady_stamps(10), 0);
    const Replayed replayed = replay(std::vector{recording_spec("ü", place / "Kamera links ü.oni")});
    EXPECT_EQ(replayed.lines.size(), 10U) << replayed.health[0].reason;
    expect_finished(replayed);
}

TEST(ReplayOddFiles, PathLongerThanOpenniTakes) {
    ScratchFolder folder;
    const auto deep =
        folder / (std::string(120, 'a') + "/" + std::string(120, 'b') + "/" + std::string(60, 'c'));
    std::filesystem::create_directories(deep);
    write_recording(deep / "left.oni", steady_stamps(10), 0);
    const Replayed replayed = replay(std::vector{recording_spec("left", deep / "left.oni")});
    EXPECT_EQ(replayed.lines.size(), 10U) << replayed.health[0].reason;
}

}  // namespace
}  // namespace deixis
