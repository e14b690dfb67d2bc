// Rigs and frames folders for session tests.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "appliance/calibration/calibration_file.h"
#include "appliance/sessions/depth_png.h"
#include "appliance/sessions/session_writer.h"
#include "tests/appliance/sessions/sample_images.h"
#include "tests/appliance/sessions/scratch_folder.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis::testing {

inline CalibratedSensor sample_sensor(const std::string& name, SensorKind kind, int width, int height) {
    CalibratedSensor sensor;
    sensor.name = name;
    sensor.kind = kind;
    sensor.camera.width = width;
    sensor.camera.height = height;
    sensor.camera.fx = sensor.camera.fy = 0.9 * width;
    sensor.camera.cx = (width - 1) / 2.0;
    sensor.camera.cy = (height - 1) / 2.0;
    return sensor;
}

/// Two depth sensors of different size.
inline SensorRig sample_rig() {
    SensorRig rig;
    rig.sensors.push_back(sample_sensor("left", SensorKind::depth, 24, 16));
    rig.sensors.push_back(sample_sensor("right", SensorKind::depth, 33, 17));
    return rig;
}

inline SessionOrigin sample_origin() {
    return {"a test", "2026-11-22T10:00:00Z", {{"deixis", "0.1.0"}}};
}

/// A frames folder of `rig` with `counts[i]` frames of sensor i; stamps from 1 s on, 40 ms apart.
inline void write_frames_folder(const std::filesystem::path& folder, const SensorRig& rig,
                                const std::vector<int>& counts) {
    std::filesystem::create_directories(folder);
    ASSERT_TRUE(write_calibration(rig, folder / "calibration.toml"));
    for (size_t s = 0; s < rig.sensors.size(); ++s) {
        const CalibratedSensor& sensor = rig.sensors[s];
        std::filesystem::create_directories(folder / sensor.name);
        std::string csv = "frame,timestamp_us\n";
        for (int i = 0; i < counts[s]; ++i) {
            const std::string digits = std::to_string(1'000'000 + i).substr(1);
            const DepthImage image =
                room_image(sensor.camera.width, sensor.camera.height, static_cast<uint32_t>(i));
            ASSERT_TRUE(write_depth_png(image, folder / sensor.name / (digits + ".png")));
            csv += std::to_string(i);
            csv += ',';
            csv += std::to_string(1'000'000 + 40'000 * i + static_cast<int>(s)) + "\n";
        }
        write_bytes(folder / sensor.name / "timestamps.csv", csv);
    }
}

}  // namespace deixis::testing
