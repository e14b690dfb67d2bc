// The frames folder that another program wrote: imported, then read back through our reader and stock
// OpenNI2.
#include <gtest/gtest.h>

#include <cstdlib>

#include "appliance/sessions/frame_stamps.h"
#include "appliance/sessions/import_frames.h"
#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/session.h"
#include "tests/appliance/sessions/scratch_folder.h"
#include "tests/appliance/sessions/stock_playback.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;
using namespace testing;  // NOLINT: our own helpers

fs::path data_folder() {
    if (const char* data = std::getenv("DEIXIS_DATA")) return data;
    const char* source = std::getenv("DEIXIS_SOURCE");
    return fs::path(source == nullptr ? "." : source) / "../shared/data";
}

TEST(ImportSample, EveryFrameComesBackBitForBit) {
    const fs::path frames = data_folder() / "sample_frames";
    if (!fs::exists(frames)) GTEST_SKIP() << "no " << frames;
    const ScratchFolder scratch;
    const auto report = import_frames(frames, scratch / "out", {"sample", "2026-11-22T10:00:00Z", {}});
    ASSERT_TRUE(report) << report.error().sentence;
    EXPECT_TRUE(report->warnings.empty());
    const auto session = open_session(scratch / "out");
    ASSERT_TRUE(session) << session.error().sentence;
    ASSERT_EQ(session->streams.size(), 2U);
    const std::vector<StockPlayback> played =
        play_with_stock_openni2({session->streams[0].file, session->streams[1].file});
    for (size_t s = 0; s < 2; ++s) {
        const SessionStream& stream = session->streams[s];
        const auto stamps = read_timestamps(frames / stream.sensor / "timestamps.csv");
        ASSERT_TRUE(stamps);
        ASSERT_EQ(stream.frames, static_cast<int64_t>(stamps->timestamp_us.size()));
        ASSERT_EQ(played[s].frames.size(), stamps->timestamp_us.size());
        const auto read = read_oni(stream.file, [&](int64_t frame, int64_t stamp, const DepthImage& image) {
            const auto i = static_cast<size_t>(frame);
            const auto png = read_depth_png(frames / stream.sensor / frame_file_name(frame), {640, 480});
            EXPECT_TRUE(png);
            EXPECT_EQ(stamp + stream.start_us, stamps->timestamp_us[i]);
            EXPECT_EQ(static_cast<int64_t>(played[s].frames[i].timestamp_us) + stream.start_us,
                      stamps->timestamp_us[i]);
            EXPECT_TRUE(image.millimetres == png->millimetres) << stream.sensor << " frame " << frame;
            EXPECT_TRUE(played[s].frames[i].image.millimetres == png->millimetres)
                << stream.sensor << " frame " << frame;
            return true;
        });
        ASSERT_TRUE(read) << read.error().sentence;
    }
    EXPECT_TRUE(session->truth);
    const auto background = read_background(*session);
    ASSERT_TRUE(background) << background.error().sentence;
    EXPECT_EQ((*background)[0].has_value(), fs::exists(frames / "background/left.png"));
}

}  // namespace
}  // namespace deixis
