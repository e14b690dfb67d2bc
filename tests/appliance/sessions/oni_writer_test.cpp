// The recording writer and its own reader: round trips, the uncoded fallback, refusals, full disks,
// interrupted files.
#include "appliance/sessions/oni_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/appliance/sessions/oni_samples.h"

namespace deixis {
namespace {

using ::testing::HasSubstr;
using namespace testing;  // NOLINT: our own helpers

TEST(OniWriter, ReadsBackBitForBit) {
    const ScratchFolder scratch;
    const std::vector<DepthImage> images = room_images(64, 48, 25);
    write_recording(scratch / "a.oni", images);
    const auto summary = walk_oni(scratch / "a.oni");
    ASSERT_TRUE(summary) << summary.error().sentence;
    EXPECT_EQ(summary->width, 64);
    EXPECT_EQ(summary->height, 48);
    EXPECT_EQ(summary->fps, 30);
    EXPECT_EQ(summary->frames, 25);
    EXPECT_EQ(summary->codec, OniCodec::table);
    EXPECT_EQ(summary->first_us, 0);
    EXPECT_EQ(summary->last_us, 24 * 33'333);
    EXPECT_DOUBLE_EQ(summary->horizontal_fov, 1.0);
    EXPECT_DOUBLE_EQ(summary->vertical_fov, 0.75);
    EXPECT_EQ(summary->data_bytes, std::filesystem::file_size(scratch / "a.oni"));
    const std::vector<ReadFrame> frames = frames_of(scratch / "a.oni");
    ASSERT_EQ(frames.size(), images.size());
    for (size_t i = 0; i < images.size(); ++i) {
        EXPECT_EQ(frames[i].timestamp_us, static_cast<int64_t>(i) * 33'333);
        EXPECT_EQ(frames[i].image.millimetres, images[i].millimetres);
    }
}

TEST(OniWriter, SameFramesGiveTheSameFile) {
    const ScratchFolder scratch;
    write_recording(scratch / "a.oni", room_images(40, 30, 5));
    write_recording(scratch / "b.oni", room_images(40, 30, 5));
    EXPECT_EQ(bytes_of(scratch / "a.oni"), bytes_of(scratch / "b.oni"));
}

TEST(OniWriter, FramesThat16zCannotHoldTurnTheFileUncoded) {
    const ScratchFolder scratch;
    std::vector<DepthImage> images = room_images(300, 200, 4);
    images.insert(images.begin() + 2, noise_image(300, 200, 1, 65534));  // more than 32768 values, jumping
    write_recording(scratch / "a.oni", images);
    const auto summary = walk_oni(scratch / "a.oni");
    ASSERT_TRUE(summary) << summary.error().sentence;
    EXPECT_EQ(summary->codec, OniCodec::none);
    EXPECT_FALSE(std::filesystem::exists(scratch / "a.oni.uncoded"));
    const std::vector<ReadFrame> frames = frames_of(scratch / "a.oni");
    ASSERT_EQ(frames.size(), 5U);
    for (size_t i = 0; i < images.size(); ++i)
        EXPECT_EQ(frames[i].image.millimetres, images[i].millimetres) << i;
}

TEST(OniWriter, InfraredHoldsEveryValue) {
    const ScratchFolder scratch;
    OniFormat format = oni_format(32, 16);
    format.infrared = true;
    auto writer = OniWriter::create(scratch / "ir.oni", format);
    ASSERT_TRUE(writer);
    const DepthImage image = noise_image(32, 16, 5, 65535);
    ASSERT_TRUE(writer->append(0, image));
    ASSERT_TRUE(writer->append(1, flat_image(32, 16, 65535)));
    ASSERT_TRUE(writer->finish());
    const auto summary = walk_oni(scratch / "ir.oni");
    ASSERT_TRUE(summary) << summary.error().sentence;
    EXPECT_TRUE(summary->infrared);
    EXPECT_EQ(frames_of(scratch / "ir.oni")[0].image.millimetres, image.millimetres);
}

TEST(OniWriter, KeepsStampsWithGapsRepeatsAndEpochs) {
    const ScratchFolder scratch;
    const std::vector<int64_t> stamps = {
        0, 0, 5, 1'700'000'000'000'000, 1'700'000'000'000'000, int64_t{1} << 61};
    auto writer = OniWriter::create(scratch / "a.oni", oni_format(4, 4));
    for (const int64_t stamp : stamps) ASSERT_TRUE(writer->append(stamp, flat_image(4, 4, 7)));
    ASSERT_TRUE(writer->finish());
    const std::vector<ReadFrame> frames = frames_of(scratch / "a.oni");
    ASSERT_EQ(frames.size(), stamps.size());
    for (size_t i = 0; i < stamps.size(); ++i) EXPECT_EQ(frames[i].timestamp_us, stamps[i]);
}

TEST(OniWriter, FieldOfViewLiesBetweenTheOuterPixelEdges) {
    CameraModel camera;
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 320;
    camera.cx = 319.5;
    camera.cy = 239.5;
    const OniFormat format = oni_format_of(camera, false);
    EXPECT_NEAR(format.horizontal_fov, 2 * std::atan(1.0), 1e-12);
    EXPECT_NEAR(format.vertical_fov, 2 * std::atan(0.75), 1e-12);
}

TEST(OniWriter, RefusesByNameAndGoesOn) {
    const ScratchFolder scratch;
    auto writer = OniWriter::create(scratch / "a.oni", oni_format(5, 4));
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->append(10, flat_image(5, 4, 1)));
    DepthImage bad = flat_image(5, 4, 1);
    bad.millimetres[7] = 65535;
    EXPECT_THAT(writer->append(20, bad).error().sentence,
                HasSubstr("a.oni: frame 1: pixel (2, 1): expected 0 to 65534 mm, found 65535"));
    EXPECT_THAT(writer->append(20, flat_image(4, 5, 1)).error().sentence,
                HasSubstr("frame 1: expected 5 x 4 pixels, found 4 x 5"));
    DepthImage torn = flat_image(5, 4, 1);
    torn.millimetres.pop_back();
    EXPECT_THAT(writer->append(20, torn).error().sentence, HasSubstr("expected 5 x 4 pixels"));
    EXPECT_THAT(writer->append(9, flat_image(5, 4, 1)).error().sentence,
                HasSubstr("frame 1: expected a timestamp not before 10, found 9"));
    EXPECT_THAT(writer->append(-1, flat_image(5, 4, 1)).error().sentence,
                HasSubstr("expected a timestamp from 0"));
    ASSERT_TRUE(writer->append(20, flat_image(5, 4, 2)));
    ASSERT_TRUE(writer->finish());
    ASSERT_TRUE(writer->finish()) << "a second finish does nothing";
    EXPECT_THAT(writer->append(30, flat_image(5, 4, 2)).error().sentence, HasSubstr("is finished"));
    EXPECT_EQ(frames_of(scratch / "a.oni").size(), 2U);
}

TEST(OniWriter, RefusesImpossibleSizesAndPlaces) {
    const ScratchFolder scratch;
    for (const auto& [width, height] :
         {std::pair{0, 4}, {4, 0}, {-1, 4}, {1697, 1698}, {65536, 1}, {1 << 20, 1 << 20}})
        EXPECT_THAT(OniWriter::create(scratch / "a.oni", oni_format(width, height)).error().sentence,
                    HasSubstr("a.oni: expected images of 1 to 2880000 pixels"));
    EXPECT_THAT(OniWriter::create(scratch / "no" / "a.oni", oni_format(4, 4)).error().sentence,
                HasSubstr("a.oni: cannot be opened: No such file or directory"));
}

TEST(OniWriter, AFullDiskIsAValue) {
    EXPECT_THAT(OniWriter::create("/dev/full", oni_format(4, 4)).error().sentence,
                HasSubstr("/dev/full: cannot be written: No space left on device"));
}

/// In a child process, whose files may not grow beyond 20 kB: the frames that went in stay, and the rest is
/// refused.
TEST(OniWriter, FramesBeforeAFullDiskStayGood) {
    const ScratchFolder scratch;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        ::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit = {20'000, 20'000};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        auto writer = OniWriter::create(scratch / "a.oni", oni_format(64, 48));
        int64_t frames = 0;
        while (writer->append(frames * 33'333, room_image(64, 48, static_cast<uint32_t>(frames)))) ++frames;
        const bool refused_again = !writer->append(frames * 33'333, noise_image(64, 48, 1, 60000));
        ::_exit(refused_again && writer->frames() == frames ? static_cast<int>(frames) : 0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    const int frames = WEXITSTATUS(status);
    ASSERT_GT(frames, 1);
    const auto mended = mend_recording(scratch / "a.oni");
    ASSERT_TRUE(mended) << mended.error().sentence;
    EXPECT_EQ(mended->frames, frames);
    const std::vector<ReadFrame> read = frames_of(scratch / "a.oni");
    ASSERT_EQ(static_cast<int>(read.size()), frames);
    for (size_t i = 0; i < read.size(); ++i)
        EXPECT_EQ(read[i].image.millimetres, room_image(64, 48, static_cast<uint32_t>(i)).millimetres);
}

TEST(OniWriter, AKilledWriterLeavesAFileThatIsMended) {
    const ScratchFolder scratch;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        auto writer = OniWriter::create(scratch / "a.oni", oni_format(33, 17));
        for (int i = 0; i < 7; ++i) {
            if (!writer->append(i * 1000, room_image(33, 17, static_cast<uint32_t>(i)))) ::_exit(1);
        }
        ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    const auto walked = walk_oni(scratch / "a.oni");
    ASSERT_FALSE(walked);
    EXPECT_THAT(
        walked.error().sentence,
        HasSubstr(
            "a.oni: byte 12: expected a finished recording; this one was interrupted and can be mended"));
    const auto mended = mend_recording(scratch / "a.oni");
    ASSERT_TRUE(mended) << mended.error().sentence;
    EXPECT_TRUE(mended->changed);
    EXPECT_EQ(mended->frames, 7);
    EXPECT_EQ(mended->cut_bytes, 0U);
    EXPECT_EQ(frames_of(scratch / "a.oni").size(), 7U);
    EXPECT_EQ(frames_of(scratch / "a.oni")[6].image.millimetres, room_image(33, 17, 6).millimetres);
    const auto again = mend_recording(scratch / "a.oni");
    ASSERT_TRUE(again);
    EXPECT_FALSE(again->changed);
}

TEST(MendRecording, EveryCutOfAnInterruptedFileKeepsItsWholeFrames) {
    const ScratchFolder scratch;
    const std::vector<DepthImage> images = room_images(5, 4, 3);
    std::vector<size_t> sizes;  // of the file after its head and after each frame
    {
        auto writer = OniWriter::create(scratch / "open.oni", oni_format(5, 4));
        sizes.push_back(std::filesystem::file_size(scratch / "open.oni"));
        for (size_t i = 0; i < images.size(); ++i) {
            ASSERT_TRUE(writer->append(static_cast<int64_t>(i) * 100, images[i]));
            sizes.push_back(std::filesystem::file_size(scratch / "open.oni"));
        }
    }
    const std::string whole = bytes_of(scratch / "open.oni");
    ASSERT_EQ(whole.size(), sizes.back());
    for (size_t cut = 0; cut <= whole.size(); ++cut) {
        if (cut + 1 < sizes[0] && cut % 13 != 0) continue;  // the head is all or nothing
        write_bytes(scratch / "cut.oni", whole.substr(0, cut));
        const auto mended = mend_recording(scratch / "cut.oni");
        if (cut < sizes[0]) {
            ASSERT_FALSE(mended) << cut;
            ASSERT_THAT(mended.error().sentence, HasSubstr("cut.oni: byte ")) << cut;
            ASSERT_EQ(bytes_of(scratch / "cut.oni"), whole.substr(0, cut)) << "a refused file stays as it is";
            continue;
        }
        ASSERT_TRUE(mended) << cut << ": " << mended.error().sentence;
        const auto frames = std::upper_bound(sizes.begin(), sizes.end(), cut) - sizes.begin() - 1;
        ASSERT_EQ(mended->frames, frames) << cut;
        ASSERT_EQ(mended->cut_bytes, cut - sizes[static_cast<size_t>(frames)]) << cut;
        ASSERT_EQ(static_cast<int64_t>(frames_of(scratch / "cut.oni").size()), frames) << cut;
    }
}

TEST(MendRecording, EveryCutOfAFinishedFileIsRefusedByTheWalkAndMended) {
    const ScratchFolder scratch;
    write_recording(scratch / "a.oni", room_images(5, 4, 3));
    const std::string whole = bytes_of(scratch / "a.oni");
    for (size_t cut = 0; cut < whole.size(); ++cut) {
        const std::string part = whole.substr(0, cut);
        const auto walked = walk_oni(as_bytes(part), "part.oni");
        ASSERT_FALSE(walked) << cut;
        ASSERT_THAT(walked.error().sentence, HasSubstr("part.oni: byte ")) << cut;
        if (cut % 11 != 0) continue;  // mending waits for the disk
        write_bytes(scratch / "cut.oni", part);
        const auto mended = mend_recording(scratch / "cut.oni");
        if (!mended) continue;
        ASSERT_TRUE(mended->changed) << cut;
        const auto again = walk_oni(scratch / "cut.oni");
        ASSERT_TRUE(again) << cut << ": " << again.error().sentence;
        ASSERT_EQ(again->frames, mended->frames) << cut;
    }
}

TEST(MendRecording, TakesOffTheZeroTailThatTheStockRecorderLeaves) {
    const ScratchFolder scratch;
    write_recording(scratch / "a.oni", room_images(8, 6, 3));
    const std::string whole = bytes_of(scratch / "a.oni");
    write_bytes(scratch / "tail.oni", whole);
    std::filesystem::resize_file(scratch / "tail.oni", uint64_t{3} << 30);  // sparse
    const auto walked = walk_oni(scratch / "tail.oni");
    ASSERT_TRUE(walked) << walked.error().sentence;
    EXPECT_EQ(walked->data_bytes, whole.size());
    const auto mended = mend_recording(scratch / "tail.oni");
    ASSERT_TRUE(mended);
    EXPECT_EQ(mended->cut_bytes, (uint64_t{3} << 30) - whole.size());
    EXPECT_EQ(bytes_of(scratch / "tail.oni"), whole);
}

}  // namespace
}  // namespace deixis
