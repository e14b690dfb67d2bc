// An imported session beside the frames folder that it came from.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "appliance/sessions/depth_png.h"
#include "appliance/sessions/frame_stamps.h"
#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/session.h"
#include "tests/appliance/sessions/stock_playback.h"

namespace deixis::testing {

/// Every frame of `session`, through our reader and through stock OpenNI2, is the PNG of `frames` with the
/// stamp of its CSV.
inline void expect_same_frames(const Session& session, const std::filesystem::path& frames) {
    std::vector<std::filesystem::path> files;
    for (const SessionStream& stream : session.streams) files.push_back(stream.file);
    const std::vector<StockPlayback> played = play_with_stock_openni2(files);
    for (size_t s = 0; s < session.streams.size(); ++s) {
        const SessionStream& stream = session.streams[s];
        const CameraModel& camera = session.rig.sensors[s].camera;
        const auto stamps = read_timestamps(frames / stream.sensor / "timestamps.csv");
        ASSERT_TRUE(stamps);
        EXPECT_EQ(played[s].status, 0U);
        EXPECT_EQ(played[s].width, camera.width);
        EXPECT_EQ(played[s].height, camera.height);
        ASSERT_EQ(played[s].frames.size(), stamps->timestamp_us.size());
        int64_t count = 0;
        const auto read = read_oni(stream.file, [&](int64_t frame, int64_t stamp, const DepthImage& image) {
            const auto i = static_cast<size_t>(frame);
            const auto png = read_depth_png(frames / stream.sensor / frame_file_name(frame),
                                            {camera.width, camera.height});
            EXPECT_TRUE(png);
            EXPECT_EQ(stamp + stream.start_us, stamps->timestamp_us[i]);
            EXPECT_EQ(static_cast<int64_t>(played[s].frames[i].timestamp_us) + stream.start_us,
                      stamps->timestamp_us[i]);
            EXPECT_TRUE(image.millimetres == png->millimetres) << stream.sensor << " frame " << frame;
            EXPECT_TRUE(played[s].frames[i].image.millimetres == png->millimetres)
                << stream.sensor << " frame " << frame;
            ++count;
            return !::testing::Test::HasFailure();
        });
        ASSERT_TRUE(read) << read.error().sentence;
        EXPECT_EQ(count, stream.frames);
    }
}

}  // namespace deixis::testing
