// Both sample bumpers at random places, a worker and a trolley in the way, a third to a half hidden, noisy
// full-size images: found or not found, but never a wrong pose called tracking. Prints the rates.
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <random>

#include "appliance/parts/part_model.h"
#include "appliance/parts/sample_bumper.h"
#include "tests/tracking/part/synthetic_cell.h"
#include "tracking/part/part_tracker.h"

namespace deixis {
namespace {

using namespace synthetic;

constexpr int framesets = 24;  // three search attempts

struct Tally {
    int cases = 0, found = 0, frames = 0, wrong = 0;
    double worst_mm = 0, worst_degree = 0;
};

class PartStressTest : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        for (const SampleBumper variant : {SampleBumper::a, SampleBumper::b}) {
            const auto file = std::filesystem::temp_directory_path() /
                              ("deixis-stress-" + std::to_string(::getpid()) + ".step");
            ASSERT_TRUE(write_sample_bumper(variant, file));
            const auto mesh = load_mesh(file, 0.001);
            std::filesystem::remove(file);
            ASSERT_TRUE(mesh) << mesh.error().sentence;
            meshes_.push_back(*mesh);
            models_.push_back(*ReferenceModel::build(*mesh, {}));
        }
    }
    static void TearDownTestSuite() {
        meshes_.clear();
        models_.clear();
    }

    /// One part for about a second: how often it is tracked, and how far off at worst.
    static void run_case(const std::shared_ptr<const ReferenceModel>& model, const SurfaceMesh& stands_there,
                         bool is_the_part, unsigned seed, double largest_yaw, Tally& tally) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> u(-1, 1);
        const MeshBounds bounds = bounds_of(stands_there);
        const Eigen::Vector3d middle = (0.5 * (bounds.min + bounds.max)).cast<double>();
        RigidTransform truth;
        truth.rotation = (Eigen::AngleAxisd(largest_yaw * u(random), Eigen::Vector3d::UnitZ()) *
                          Eigen::AngleAxisd(0.25 * u(random), Eigen::Vector3d::UnitX()))
                             .toRotationMatrix();
        truth.translation = Eigen::Vector3d(0.5 * u(random), 0.15 + 0.35 * u(random), 0.9 + 0.2 * u(random)) -
                            truth.rotation * middle;
        const auto sensors = two_kinects(seed);
        const Eigen::Vector3f hand =
            (truth * Eigen::Vector3d(0.5 * u(random), bounds.min.y() - 0.03, 0.25)).cast<float>();
        const std::vector<SurfaceMesh> scene = {moved(stands_there, truth), trolley(truth, bounds),
                                                person({static_cast<float>(0.7 * u(random)), -0.7F}, hand),
                                                box({-1.9F, 1.5F, 0}, {1.9F, 1.6F, 1.8F})};
        const Frameset empty = render(sensors, {scene.back()}, 0, seed + 5000);
        PartTracker tracker(model, sensors, {});
        ++tally.cases;
        // Three noisy views in turn: the noise of a sensor is new in each, the time to render them is not.
        std::vector<Frameset> views;
        for (unsigned i = 0; i < 3; ++i) views.push_back(render(sensors, scene, 0, 100 * seed + i));
        for (int i = 0; i < framesets; ++i) {
            Frameset& frameset = views[i % views.size()];
            frameset.timestamp_us = 33'333 * i;
            for (DepthFrame& f : frameset.frames) f.timestamp_us = frameset.timestamp_us;
            const PartEstimate& e = tracker.update(frameset, surface_points(sensors, frameset, empty));
            if (i + 1 == framesets && e.state == PartState::tracking) ++tally.found;
            if (e.state != PartState::tracking) continue;
            const PoseError error = error_between(e.world_from_part, truth);
            ++tally.frames;
            tally.worst_mm = std::max(tally.worst_mm, error.mm);
            tally.worst_degree = std::max(tally.worst_degree, error.degree);
            if (!is_the_part || error.mm > 10 || error.degree > 1) ++tally.wrong;
        }
    }

    static void print(const char* name, const Tally& t) {
        std::printf("%-28s found %d of %d, wrong %d of %d frames, worst %.1f mm %.2f degrees\n", name,
                    t.found, t.cases, t.wrong, t.frames, t.worst_mm, t.worst_degree);
    }

    static inline std::vector<SurfaceMesh> meshes_;
    static inline std::vector<std::shared_ptr<const ReferenceModel>> models_;
};

TEST_F(PartStressTest, FrontTowardsTheSensors) {
    Tally tally;
    for (unsigned i = 0; i < 10; ++i) run_case(models_[i % 2], meshes_[i % 2], true, 200 + i, 0.7, tally);
    print("front towards the sensors", tally);
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_GE(tally.found, 9);
}

TEST_F(PartStressTest, AnyHeading) {
    Tally tally;
    for (unsigned i = 0; i < 8; ++i) run_case(models_[i % 2], meshes_[i % 2], true, 300 + i, 3.1, tally);
    print("any heading", tally);
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_GE(tally.found, 5);
}

TEST_F(PartStressTest, TheOtherBumperIsNotTaken) {
    Tally tally;
    for (unsigned i = 0; i < 8; ++i) run_case(models_[1 - i % 2], meshes_[i % 2], false, 400 + i, 0.7, tally);
    print("the other bumper stands there", tally);
    EXPECT_EQ(tally.wrong, 0);
}

}  // namespace
}  // namespace deixis
