// Learns the empty cell from a session that brings no background. In: every Nth depth image; out: one image a
// sensor.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// Keeps a few depth modes a pixel and answers with the farthest one that was seen often enough: whatever
/// stands before it came or went. A part that rests all session long ends up in the background; the part
/// tracker looks at all points, so it is found nevertheless. The order of the images matters only within the
/// noise.
class BackgroundLearner {
  public:
    struct Params {
        double base_mm = 15;           ///< half width of a mode at zero distance [mm]
        double step_per_m2 = 2.85e-3;  ///< disparity step [m/m^2]
        double mode_steps = 2.5;       ///< half width of a mode in disparity steps, added to base_mm
        int support_frames = 3;        ///< images that a mode needs at least
        double support_share = 0.02;   ///< and at least this share of the images that measured the pixel

        InvalidSettings validate() const;
    };

    BackgroundLearner(const std::vector<CalibratedSensor>& depth_sensors, Params params);

    /// Images of another size than the sensor's are ignored.
    void add(size_t sensor, const DepthImage& depth);

    /// One image a sensor, 0 = unknown; none for a sensor that gave no image.
    std::vector<std::optional<DepthImage>> background() const;

  private:
    static constexpr int kModes = 5;
    struct Mode {
        float mean = 0;  ///< [mm]
        uint32_t count = 0;
    };
    struct PerSensor {
        int width = 0, height = 0;
        uint32_t images = 0;
        std::vector<Mode> modes;  ///< kModes a pixel
    };

    Params params_;
    std::vector<PerSensor> sensors_;
};

}  // namespace deixis
