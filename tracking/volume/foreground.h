// Foreground: which pixels of each depth image show something that the empty cell does not. In: framesets;
// out: masks.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// A pixel is foreground when it is nearer than the background by more than the sensor's noise there, and its
/// neighbours agree (speckle and flying pixels are dropped). Where it is farther for some frames the
/// background was a thing that has moved away, and the farther surface replaces it at once; where it agrees,
/// the background follows slow drift. Where the background is unknown every measured pixel is foreground, but
/// small unknown spots are filled from around them first. Deterministic, one thread, no allocation after the
/// first update.
class ForegroundModel {
  public:
    struct Params {
        double base_mm = 12;           ///< threshold at zero distance [mm]
        double step_per_m2 = 2.85e-3;  ///< disparity step of the sensor [m/m^2]
        double threshold_steps = 2.2;  ///< threshold in disparity steps, added to base_mm
        int moved_frames = 6;          ///< frames farther than the background before it is replaced
        double drift_rate = 0.01;      ///< share of the difference followed each frame, 0 to 1
        int hole_pixels = 6;           ///< unknown background is filled from this far [pixel]
        int neighbours = 3;            ///< of 8, foreground and at a like depth, that a pixel needs

        InvalidSettings validate() const;
    };

    /// `background` has one image a sensor, or none for it; an image of another size than the sensor's counts
    /// as none.
    ForegroundModel(std::vector<CalibratedSensor> depth_sensors,
                    std::vector<std::optional<DepthImage>> background, Params params);

    /// Replaces what is known of the empty cell; an image of another size than the sensor's is ignored.
    void set_background(size_t sensor, const DepthImage& image);

    /// One call a frameset. A sensor that is absent, or whose image has another size than calibrated, gets a
    /// mask of zeros for this frame and keeps its background.
    void update(const Frameset& frameset);

    /// Row-major, 1 = foreground. Valid until the next update. Never set where the image has no measurement.
    std::span<const uint8_t> mask(size_t sensor) const { return sensors_[sensor].mask; }

    /// Depth of the empty cell as known now [mm], 0 = unknown.
    std::span<const float> background_mm(size_t sensor) const { return sensors_[sensor].background; }

    size_t sensor_count() const { return sensors_.size(); }

  private:
    struct PerSensor {
        int width = 0, height = 0;
        std::vector<float> background;   ///< [mm], 0 = unknown
        std::vector<float> threshold;    ///< [mm]
        std::vector<uint8_t> farther;    ///< frames in which the pixel was farther than the background
        std::vector<uint8_t> candidate;  ///< before neighbours are asked
        std::vector<uint8_t> mask;
    };

    void compare(PerSensor& sensor, const DepthImage& depth) const;
    void ask_neighbours(PerSensor& sensor, const DepthImage& depth) const;
    float threshold_at(float depth_mm) const;

    Params params_;
    std::vector<PerSensor> sensors_;
};

}  // namespace deixis
