// A walking person of the sample frames: foreground, carving and worker against the true joints.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "appliance/calibration/calibration_file.h"
#include "appliance/sessions/depth_png.h"
#include "tracking/volume/background_learner.h"
#include "tracking/volume/carving.h"
#include "tracking/volume/cell_bounds.h"
#include "tracking/volume/surface_fusion.h"
#include "tracking/volume/worker_volume.h"

namespace deixis {
namespace {

std::filesystem::path data_folder() {
    const char* given = std::getenv("DEIXIS_DATA");
    if (given != nullptr) return given;
    const char* source = std::getenv("DEIXIS_SOURCE");
    return std::filesystem::path(source != nullptr ? source : ".") / "../shared/data";
}

struct TruePose {
    int64_t timestamp_us = 0;
    std::map<std::string, Eigen::Vector3d> joints;
};

class SampleFrames : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = data_folder() / "sample_frames";
        if (!std::filesystem::exists(folder_ / "calibration.toml"))
            GTEST_SKIP() << "DEIXIS_DATA has no sample_frames";
        const auto calibration = read_calibration(folder_ / "calibration.toml");
        ASSERT_TRUE(calibration) << calibration.error().sentence;
        rig_ = calibration->rig;
        for (const CalibratedSensor& sensor : rig_.sensors) {
            background_.emplace_back(image(sensor, folder_ / "background" / (sensor.name + ".png")));
            stamps_.push_back(read_stamps(folder_ / sensor.name / "timestamps.csv"));
        }
        read_truth();
    }

    static DepthImage image(const CalibratedSensor& sensor, const std::filesystem::path& file) {
        auto read = read_depth_png(file, {sensor.camera.width, sensor.camera.height});
        EXPECT_TRUE(read) << read.error().sentence;
        return read ? *read : DepthImage{};
    }

    static std::vector<int64_t> read_stamps(const std::filesystem::path& file) {
        std::ifstream in(file);
        std::string line;
        std::getline(in, line);
        std::vector<int64_t> stamps;
        while (std::getline(in, line))
            if (const auto comma = line.find(','); comma != std::string::npos)
                stamps.push_back(std::stoll(line.substr(comma + 1)));
        return stamps;
    }

    void read_truth() {
        std::ifstream in(folder_ / "truth.jsonl");
        std::string line;
        while (std::getline(in, line)) {
            const auto object = nlohmann::json::parse(line);
            TruePose& pose = truth_.emplace_back();
            pose.timestamp_us = object.at("timestamp_us");
            for (const auto& [name, p] : object.at("joints").items())
                pose.joints[name] =
                    Eigen::Vector3d(p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
        }
        ASSERT_FALSE(truth_.empty());
    }

    static size_t nearest(const std::vector<int64_t>& stamps, int64_t stamp) {
        size_t best = 0;
        for (size_t k = 0; k < stamps.size(); ++k)
            if (std::abs(stamps[k] - stamp) < std::abs(stamps[best] - stamp)) best = k;
        return best;
    }

    Frameset frameset(size_t k) const {
        Frameset frameset{stamps_[0][k], {}};
        for (size_t s = 0; s < rig_.sensors.size(); ++s) {
            const size_t frame = nearest(stamps_[s], frameset.timestamp_us);
            char name[16];
            std::snprintf(name, sizeof name, "%06zu.png", frame);
            DepthFrame& out = frameset.frames.emplace_back();
            out.timestamp_us = stamps_[s][frame];
            out.present = std::abs(out.timestamp_us - frameset.timestamp_us) <= 17'000;
            out.depth = image(rig_.sensors[s], folder_ / rig_.sensors[s].name / name);
        }
        return frameset;
    }

    const TruePose& truth_at(int64_t stamp) const {
        const TruePose* best = &truth_.front();
        for (const TruePose& pose : truth_)
            if (std::abs(pose.timestamp_us - stamp) < std::abs(best->timestamp_us - stamp)) best = &pose;
        return *best;
    }

    /// Walks through the session; returns the largest error of the top of the head [m].
    double follow(const std::vector<std::optional<DepthImage>>& background, const Box& cell) {
        ForegroundModel foreground(rig_.sensors, background, {});
        SurfaceFusion fusion(rig_.sensors, cell, {});
        VoxelCarver carver(rig_.sensors, cell, {});
        WorkerVolume worker({});
        double worst = 0;
        for (size_t k = 0; k < stamps_[0].size(); k += 3) {
            const Frameset now = frameset(k);
            foreground.update(now);
            const SurfacePoints& points = fusion.update(now, foreground);
            const VoxelGrid& grid = carver.update(now, foreground);
            const WorkerBody& body = worker.update(now.timestamp_us, grid, points, {});
            const TruePose& truth = truth_at(now.timestamp_us);
            EXPECT_TRUE(body.present) << "frame " << k;
            if (!body.present) continue;
            worst = std::max(worst, (body.head_top.cast<double>() - truth.joints.at("head")).norm());
            for (const auto& [name, joint] : truth.joints) {
                if (name == "head" || !cell.contains(joint)) continue;
                EXPECT_NE(grid.state(grid.lattice.find(joint.cast<float>())), VoxelState::free)
                    << name << " was carved in frame " << k;
            }
        }
        return worst;
    }

    std::filesystem::path folder_;
    SensorRig rig_;
    std::vector<std::optional<DepthImage>> background_;
    std::vector<std::vector<int64_t>> stamps_;
    std::vector<TruePose> truth_;
};

TEST_F(SampleFrames, TheWalkerIsFoundInEveryFrame) {
    ASSERT_TRUE(rig_.cell);
    EXPECT_LT(follow(background_, *rig_.cell), 0.15);
}

TEST_F(SampleFrames, WithoutCellNamedTheBackgroundBoundsOneThatHoldsHim) {
    SensorRig rig = rig_;
    rig.cell.reset();
    const Box cell = cell_bounds(rig, rig.sensors, background_);
    for (const TruePose& truth : truth_)
        for (const auto& [name, joint] : truth.joints) ASSERT_TRUE(cell.contains(joint)) << name;
    EXPECT_LT(follow(background_, cell), 0.15);
}

TEST_F(SampleFrames, TheBackgroundIsLearnedFromTheWalkItself) {
    BackgroundLearner learner(rig_.sensors, {});
    for (size_t k = 0; k < stamps_[0].size(); k += 2) {
        const Frameset now = frameset(k);
        for (size_t s = 0; s < now.frames.size(); ++s) learner.add(s, now.frames[s].depth);
    }
    const auto learned = learner.background();
    for (size_t s = 0; s < learned.size(); ++s) {
        ASSERT_TRUE(learned[s]);
        size_t known = 0, near = 0;
        for (size_t i = 0; i < learned[s]->millimetres.size(); ++i) {
            const int given = background_[s]->millimetres[i], found = learned[s]->millimetres[i];
            if (given == 0 || found == 0) continue;
            ++known;
            near += std::abs(given - found) < 20 + 0.009 * given * given / 1000.0;
        }
        EXPECT_GT(static_cast<double>(near), 0.95 * static_cast<double>(known));
    }
}

}  // namespace
}  // namespace deixis
