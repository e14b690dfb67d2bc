// What tests of real sensor processes share: the program, a scratch folder, recordings, patience with a
// deadline.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "appliance/sensors/frame_source.h"
#include "appliance/sensors/host_clock.h"
#include "appliance/sessions/oni_writer.h"
#include "tests/appliance/sensors/ring_images.h"

namespace deixis::test {

inline std::filesystem::path deixis_program() {
    const char* folder = std::getenv("DEIXIS_BIN");
    return std::filesystem::path(folder == nullptr ? "bin" : folder) / "deixis";
}

/// The private OpenNI2 folder with the virtual sensors, beside the programs.
inline std::filesystem::path driver_folder() {
    return deixis_program().parent_path().parent_path() / "lib";
}

/// A folder of its own, removed at the end.
class ScratchFolder {
  public:
    ScratchFolder() {
        static int number = 0;
        path_ = std::filesystem::temp_directory_path() /
                ("deixis-sensors-" + std::to_string(getpid()) + "-" + std::to_string(++number));
        std::filesystem::create_directories(path_);
    }
    ~ScratchFolder() { std::filesystem::remove_all(path_); }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

constexpr int stage_width = 160, stage_height = 120;

/// A recording of numbered images with these stamps.
inline void write_recording(const std::filesystem::path& path, const std::vector<int64_t>& stamps,
                            uint32_t sensor = 0, int width = stage_width, int height = stage_height) {
    auto writer = OniWriter::create(path, {width, height, 1.0, 0.8, false, 30});
    ASSERT_TRUE(writer) << writer.error().sentence;
    for (size_t i = 0; i < stamps.size(); ++i) {
        const auto done =
            writer->append(stamps[i], numbered_image(width, height, static_cast<uint32_t>(i + 1), sensor));
        ASSERT_TRUE(done) << done.error().sentence;
    }
    const auto finished = writer->finish();
    ASSERT_TRUE(finished) << finished.error().sentence;
}

inline std::vector<int64_t> steady_stamps(int count, int64_t first_us = 0, double gap_us = 33'333.3) {
    std::vector<int64_t> stamps;
    for (int i = 0; i < count; ++i) stamps.push_back(first_us + std::llround(i * gap_us));
    return stamps;
}

inline SensorSpec recording_spec(const std::string& name, const std::filesystem::path& path) {
    SensorSpec spec;
    spec.name = name;
    spec.uri = path;
    spec.recording = true;
    spec.width = stage_width;
    spec.height = stage_height;
    return spec;
}

inline SensorSpec virtual_spec(const std::string& name) {
    SensorSpec spec;
    spec.name = name;
    spec.uri = "virtual://" + name;
    spec.width = stage_width;
    spec.height = stage_height;
    return spec;
}

inline FrameSourceParams stage_params() {
    FrameSourceParams params;
    params.program = deixis_program();
    params.driver_folder = driver_folder();
    params.restart_delay = std::chrono::milliseconds(50);
    return params;
}

inline std::unique_ptr<FrameSource> open_stage(const std::vector<SensorSpec>& specs,
                                               const FrameSourceParams& params) {
    auto source = open_sensors(specs, params);
    EXPECT_TRUE(source) << source.error().sentence;
    return source ? std::move(*source) : nullptr;
}

/// Calls `act` until it is true or the time is over.
inline bool within(std::chrono::seconds limit, const std::function<bool()>& act) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (std::chrono::steady_clock::now() < end)
        if (act()) return true;
    return false;
}

}  // namespace deixis::test
