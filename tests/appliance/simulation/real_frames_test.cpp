// Our noise against real Kinect frames, where they are at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <vector>

#include "appliance/simulation/sensor_noise.h"
#include "tests/appliance/simulation/data_folder.h"

namespace deixis {
namespace {

/// Median spacing of distinct depths between 0.9 and 2 m, over z^2 [1/m].
double median_step(const std::set<uint16_t>& depths) {
    std::vector<double> steps;
    for (auto a = depths.lower_bound(900); a != depths.end() && std::next(a) != depths.end(); ++a) {
        const double z = 0.0005 * (*a + *std::next(a));
        if (z < 2.0) steps.push_back(0.001 * (*std::next(a) - *a) / (z * z));
    }
    if (steps.empty()) return 0;
    std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
    return steps[steps.size() / 2];
}

TEST(RealFrames, OurDepthStepsAreTheirs) {
    const std::filesystem::path folder = data_folder() / "depth/skeltrack_kinect";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no DEIXIS_DATA";
    std::set<uint16_t> real, ours;
    DepthImage image;
    const SensorNoise noise{SensorNoiseParams{}};
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".raw") continue;
        std::ifstream file(entry.path(), std::ios::binary);
        std::vector<uint16_t> pixels(640 * 480);
        file.read(reinterpret_cast<char*>(pixels.data()), static_cast<std::streamsize>(2 * pixels.size()));
        ASSERT_TRUE(file.good()) << entry.path();
        DepthLayer layer{std::vector<float>(pixels.size()), std::vector<float>(pixels.size(), 0.9F),
                         std::vector<uint8_t>(pixels.size(), 0)};
        for (size_t i = 0; i < pixels.size(); ++i) layer.z[i] = 0.001F * pixels[i];
        noise.apply(1, 0, layer, 640, 480, image);
        real.insert(pixels.begin(), pixels.end());
        ours.insert(image.millimetres.begin(), image.millimetres.end());
    }
    const double theirs = median_step(real);
    EXPECT_GT(theirs, 2.6e-3);
    EXPECT_LT(theirs, 3.0e-3);
    EXPECT_NEAR(median_step(ours), theirs, 0.15e-3);
}

}  // namespace
}  // namespace deixis
