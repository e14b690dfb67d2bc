// The whole virtual cell: determinism, and truth against what the sensors are shown.
#include "appliance/simulation/virtual_cell.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <thread>

#include "tests/appliance/simulation/small_cell.h"
#include "tracking/geometry/ray_caster.h"

namespace deixis {
namespace {

using Eigen::Vector3d;

const std::string three_points = R"([[action]]
do = "point"
arm = "left"
[[action]]
do = "point"
arm = "right"
meant = false
[[action]]
do = "point"
arm = "right"
touch = true
)";

VirtualCell cell_of(const std::string& text, uint64_t seed) {
    auto cell = VirtualCell::create(parsed(text), seed, curved_panel());
    EXPECT_TRUE(cell.has_value()) << cell.error().sentence;
    return std::move(*cell);
}

TEST(VirtualCell, SameSeedSameBytesForAnyOrderAndThreads) {
    const std::string text = small_scenario(three_points);
    VirtualCell a = cell_of(text, 3), b = cell_of(text, 3), other = cell_of(text, 4);
    ASSERT_EQ(a.frame_count(0), b.frame_count(0));
    const std::vector<int64_t> frames{20, 75, 21, 140};
    std::vector<std::vector<DepthFrame>> one(2, std::vector<DepthFrame>(frames.size())), two = one;
    for (size_t s = 0; s < 2; ++s)
        for (size_t i = 0; i < frames.size(); ++i) a.render(s, frames[i], one[s][i]);
    {
        std::vector<std::jthread> threads;
        for (size_t s = 0; s < 2; ++s)
            threads.emplace_back([&, s] {
                for (size_t i = frames.size(); i-- > 0;) b.render(s, frames[i], two[s][i]);
            });
    }
    for (size_t s = 0; s < 2; ++s)
        for (size_t i = 0; i < frames.size(); ++i) {
            EXPECT_EQ(one[s][i].depth.millimetres, two[s][i].depth.millimetres);
            EXPECT_EQ(one[s][i].timestamp_us, two[s][i].timestamp_us);
            EXPECT_EQ(one[s][i].host_us, two[s][i].host_us);
        }
    EXPECT_EQ(a.background(0).millimetres, b.background(0).millimetres);
    DepthFrame different;
    other.render(0, 20, different);
    EXPECT_NE(different.depth.millimetres, one[0][0].depth.millimetres);
}

TEST(VirtualCell, FingertipAndJointsLieInsideWhatIsSeen) {
    VirtualCell cell = cell_of(small_scenario(three_points), 6);
    DepthImage image;
    size_t seen = 0;
    for (double t = 0.5; t < cell.duration_s(); t += 0.9) {
        const CellTruth truth = cell.truth(t);
        ASSERT_TRUE(truth.joints.has_value());
        for (size_t s = 0; s < 2; ++s) {
            cell.render_clean(s, t, image);
            const CalibratedSensor& sensor = cell.rig().sensors[s];
            // Joint and how deep it lies in the body at most. The head's joint is the top of the skull, on
            // the outline: what must be seen is the head below it.
            const Vector3d skull = (*truth.joints)[0], neck = (*truth.joints)[1];
            const std::vector<std::pair<Vector3d, double>> places{{skull + 0.4 * (neck - skull), 0.16},
                                                                  {(*truth.joints)[1], 0.16},
                                                                  {(*truth.joints)[4], 0.10},
                                                                  {(*truth.joints)[5], 0.10},
                                                                  {(*truth.joints)[6], 0.09},
                                                                  {(*truth.joints)[7], 0.09},
                                                                  {(*truth.joints)[8], 0.26}};
            for (const auto& [joint, depth] : places) {
                const Vector3d p = sensor.camera_from_world * joint;
                const Eigen::Vector2d pixel = sensor.camera.project(p);
                const auto u = static_cast<int>(std::lround(pixel.x())),
                           v = static_cast<int>(std::lround(pixel.y()));
                if (u < 0 || v < 0 || u >= image.width || v >= image.height) continue;
                const double z = 0.001 * image.at(u, v);
                EXPECT_LT(z, p.z() + 0.05) << "the surface lies before the joint, t " << t << " sensor " << s;
                if (z > p.z() - depth) ++seen;
            }
        }
    }
    EXPECT_GT(seen, 60U) << "most joints are seen through nothing but the body";
}

TEST(VirtualCell, MeantHoldsAimAtTheirSpotOnTheSkin) {
    const SurfaceMesh panel = curved_panel();
    RayCaster skin;
    skin.add(panel);
    skin.commit();
    for (const auto& [mode, name] : std::vector<std::pair<AimMode, std::string>>{
             {AimMode::eye, "eye"}, {AimMode::forearm, "forearm"}, {AimMode::finger, "finger"}}) {
        VirtualCell cell = cell_of(
            small_scenario("aim = \"" + name + "\"\nscatter_deg = 1\ngap = [0.05, 0.2]\n" + three_points), 2);
        std::set<int> holds;
        for (double t = 0; t < cell.duration_s(); t += 0.03) {
            const CellTruth truth = cell.truth(t);
            if (!truth.pointing || !truth.pointing->target_part) continue;
            holds.insert(truth.pointing->hold);
            const Vector3d target = *truth.pointing->target_part;
            ASSERT_TRUE(skin.nearest(target.cast<float>(), 0.001F).has_value()) << "on the CAD surface";
            const Vector3d spot = *truth.world_from_part * target;
            const size_t side = truth.pointing->left_arm ? 0 : 1;
            const Vector3d tip = truth.fingertips[side], elbow = (*truth.joints)[4 + side],
                           wrist = (*truth.joints)[6 + side];
            const Vector3d from = mode == AimMode::eye ? truth.eye : mode == AimMode::forearm ? elbow : wrist;
            // Scatter of 1 degree along each axis about the line's origin, 3.5 sigma, and the tremor.
            const double allowed = 3.5 * 1.42 * std::numbers::pi / 180 * (spot - from).norm() + 0.006;
            EXPECT_LT(distance_off_line(spot, from, tip), allowed)
                << name << " hold " << truth.pointing->hold;
            const double gap = (spot - tip).norm();
            if (truth.pointing->touch)
                EXPECT_LT(gap, allowed + 0.01);
            else
                EXPECT_LT(gap, 0.2 + allowed);
            EXPECT_LT((elbow - spot).norm() + 0.02,
                      (elbow - (*truth.joints)[2 + side]).norm() + (elbow - spot).norm());
        }
        EXPECT_EQ(holds.size(), 3U) << name;
    }
}

TEST(VirtualCell, HoldsLastAsLongAsTheyShould) {
    VirtualCell cell = cell_of(small_scenario(three_points), 8);
    std::array<double, 4> seconds{};
    std::array<bool, 4> meant{};
    for (double t = 0; t < cell.duration_s(); t += 0.01) {
        const CellTruth truth = cell.truth(t);
        if (!truth.pointing) continue;
        seconds[truth.pointing->hold] += 0.01;
        meant[truth.pointing->hold] = truth.pointing->meant;
    }
    EXPECT_TRUE(meant[1] && !meant[2] && meant[3]);
    for (const int hold : {1, 3}) {
        EXPECT_GE(seconds[hold], 1.38);
        EXPECT_LE(seconds[hold], 2.02);
    }
    EXPECT_GE(seconds[2], 0.38);
    EXPECT_LE(seconds[2], 0.62);
}

TEST(VirtualCell, PartMovesOnlyWhilePushedAndTheTrapStandsWhileItMoves) {
    VirtualCell cell = cell_of(small_scenario(R"([[action]]
do = "push"
by = "corner"
pointing = true
arm = "left"
to = [0.35, 0.85]
turn_deg = 11
)"),
                               3);
    size_t pointing = 0;
    for (double t = 0.02; t < cell.duration_s(); t += 0.02) {
        const CellTruth now = cell.truth(t), before = cell.truth(t - 0.02);
        if (!now.pointing) continue;
        ++pointing;
        EXPECT_FALSE(now.pointing->meant);
        EXPECT_GT((now.world_from_part->translation - before.world_from_part->translation).norm(), 0.5e-3)
            << "more than 25 mm/s";
    }
    EXPECT_GT(pointing, 50U);
    const RigidTransform first = *cell.truth(0).world_from_part,
                         last = *cell.truth(cell.duration_s()).world_from_part;
    EXPECT_NEAR((last.translation - first.translation).head<2>().norm(), 0.36, 0.15);
    EXPECT_NEAR(rotation_between(first, last), 11 * std::numbers::pi / 180, 1e-6);
}

TEST(VirtualCell, FeetStayOnTheFloorAndBodyOutOfThePart) {
    VirtualCell cell = cell_of(
        small_scenario("[[action]]\ndo = \"walk\"\nto = [-1.2, -0.8]\nfacing_deg = 90\n" + three_points), 9);
    RayCaster skin;
    skin.add(curved_panel());
    skin.commit();
    for (double t = 0; t < cell.duration_s(); t += 0.05) {
        const CellTruth truth = cell.truth(t);
        for (const size_t ankle : {13U, 14U}) {
            EXPECT_GT((*truth.joints)[ankle].z(), 0.03);
            EXPECT_LT((*truth.joints)[ankle].z(), 0.30);
        }
        for (size_t j = 0; j < 15; ++j) {
            const Vector3d p = truth.world_from_part->inverse() * (*truth.joints)[j];
            EXPECT_FALSE(skin.nearest(p.cast<float>(), 0.02F).has_value())
                << simulated_joint_names[j] << " at " << t;
        }
    }
}

TEST(VirtualCell, StampsRiseAndSensorsPairWithin17Milliseconds) {
    const VirtualCell cell = cell_of(small_scenario(three_points), 10);
    EXPECT_GT(cell.timing(0, 0).timestamp_us, 100'000);
    for (size_t s = 0; s < 2; ++s)
        for (int64_t i = 1; i < cell.frame_count(s); ++i) {
            const FrameTiming a = cell.timing(s, i - 1), b = cell.timing(s, i);
            ASSERT_GT(b.timestamp_us, a.timestamp_us);
            ASSERT_NEAR(static_cast<double>(b.timestamp_us - a.timestamp_us), 33'333, 7'000);
            ASSERT_GT(b.host_us - b.timestamp_us, a.host_us - a.timestamp_us - 60'000);
        }
    EXPECT_NE(cell.timing(0, 5).timestamp_us - cell.timing(0, 0).timestamp_us,
              cell.timing(1, 5).timestamp_us - cell.timing(1, 0).timestamp_us);
}

TEST(VirtualCell, BackgroundShowsTheCellWithoutPartAndWorker) {
    VirtualCell cell = cell_of(small_scenario("[[action]]\ndo = \"wait\"\nseconds = 1\n"), 11);
    DepthImage shown;
    cell.render_clean(0, 0.5, shown);
    const DepthImage background = cell.background(0);
    size_t nearer = 0, farther = 0, known = 0;
    for (size_t i = 0; i < background.millimetres.size(); ++i) {
        if (background.millimetres[i] == 0) continue;
        ++known;
        const int difference = background.millimetres[i] - shown.millimetres[i];
        if (difference > 150) ++nearer;
        if (difference < -150) ++farther;
    }
    EXPECT_GT(known, background.millimetres.size() / 3);
    EXPECT_GT(nearer, 1000U) << "worker and part stand before it";
    EXPECT_LT(farther, 60U) << "nothing is in the background that is not in the cell, but for edges";
}

TEST(VirtualCell, RefusesSpotsThatAreNotOnTheSkinOrOutOfReach) {
    const auto refused = [](const std::string& target) {
        const std::string text = small_scenario(
            "[[action]]\ndo = \"wait\"\n[[action]]\ndo = \"point\"\ntarget = " + target + "\n");
        const auto cell = VirtualCell::create(parsed(text), 1, curved_panel());
        EXPECT_FALSE(cell.has_value());
        return cell.has_value() ? std::string() : cell.error().sentence;
    };
    EXPECT_EQ(refused("[0.0, 0.5, 0.2]"),
              "cell.toml: action 2 cannot be played: key \"target\" is not a point of the part's outer skin "
              "that faces the worker");
    const auto empty = VirtualCell::create(parsed(small_scenario(three_points)), 1, SurfaceMesh{});
    ASSERT_FALSE(empty.has_value());
    EXPECT_EQ(empty.error().sentence, "cell.toml: key \"part.model\" names a file without surfaces");
}

TEST(VirtualCell, SeedsDrawDifferentPeopleLensesAndPlaces) {
    std::set<std::string> descriptions;
    std::set<double> focal, height;
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        const VirtualCell cell = cell_of(small_scenario("[[action]]\ndo = \"wait\"\nseconds = 0.5\n"), seed);
        descriptions.insert(cell.description());
        focal.insert(cell.rig().sensors[0].camera.fx);
        height.insert(std::round(100 * (*cell.truth(0.2).joints)[0].z()));
        EXPECT_TRUE(cell.rig().sensors[0].camera.has_distortion());
    }
    EXPECT_EQ(focal.size(), 6U);
    EXPECT_GE(height.size(), 5U);
    EXPECT_EQ(descriptions.size(), 6U);
}

}  // namespace
}  // namespace deixis
