// Real captured motion, where it is at hand, played by our body.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "appliance/simulation/clip_motion.h"
#include "appliance/simulation/motion_clip.h"
#include "tests/appliance/simulation/data_folder.h"

namespace deixis {
namespace {

using Eigen::Vector3d;

/// Limbs point as in the clip, the feet stand on the floor, the head is up where a head is.
void check_played(const MotionClip& clip, const std::string& name) {
    const BodyDimensions d{.height = 1.7, .girth = 1};
    const ClipMotion motion(d, clip, {{0.5, -0.3}, 0}, 0);
    double lowest = 1e9;
    for (size_t i = 0; i < clip.frames.size(); i += 7) {
        const BodyPlaces places = place_body(d, motion.at(static_cast<double>(i) * clip.seconds_per_frame));
        const auto &ours = places.joints, &theirs = clip.frames[i].joints;
        for (const auto& [a, b] :
             std::vector<std::pair<int, int>>{{2, 4}, {4, 6}, {9, 11}, {11, 13}, {3, 5}, {10, 12}}) {
            // The clip may be turned about the up axis: heights and angles between limbs do not change by
            // that.
            ASSERT_NEAR((ours[b] - ours[a]).normalized().z(), (theirs[b] - theirs[a]).normalized().z(), 1e-3)
                << name << " frame " << i;
        }
        lowest = std::min({lowest, ours[13].z(), ours[14].z()});
        ASSERT_TRUE(ours[0].allFinite());
        ASSERT_NEAR((ours[4] - ours[2]).norm(), d.upper_arm(), 1e-6);
        ASSERT_LT(ours[0].z(), 2.4);
    }
    EXPECT_NEAR(lowest, d.ankle_height(), 0.06) << name;
    EXPECT_NEAR(place_body(d, motion.at(0)).joints[8].x(), 0.5, 1e-9);
}

TEST(RealClips, EveryBvhPlays) {
    const std::filesystem::path folder = data_folder() / "mocap";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no DEIXIS_DATA";
    size_t played = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (entry.path().extension() != ".bvh") continue;
        const auto clip = read_bvh(entry.path());
        ASSERT_TRUE(clip.has_value()) << clip.error().sentence;
        check_played(*clip, entry.path().filename().string());
        ++played;
    }
    EXPECT_GT(played, 70U);
}

TEST(RealClips, EveryAmcPlays) {
    const std::filesystem::path folder = data_folder() / "mocap/cmu_asfamc/02";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no DEIXIS_DATA";
    size_t played = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".amc") continue;
        const auto clip = read_asf_amc(folder / "02.asf", entry.path());
        ASSERT_TRUE(clip.has_value()) << clip.error().sentence;
        EXPECT_GT(clip->frames.size(), 100U);
        // 0.056444 m a unit (SOURCES.md): a person's legs.
        const auto& j = clip->frames[0].joints;
        EXPECT_NEAR(0.056444 * ((j[9] - j[11]).norm() + (j[11] - j[13]).norm()), 0.84, 0.12);
        check_played(*clip, entry.path().filename().string());
        ++played;
    }
    EXPECT_EQ(played, 7U);
}

}  // namespace
}  // namespace deixis
