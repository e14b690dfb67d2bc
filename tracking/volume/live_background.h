// The empty cell of a station that was started without an image of it: learned while it runs. In: framesets;
// out: a background handed to the foreground model, once a sensor.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/volume/background_learner.h"
#include "tracking/volume/foreground.h"

namespace deixis {

/// Until a sensor has given its images all that it sees is foreground. Who stands still all that time becomes
/// background, and is forgotten as soon as he moves: the foreground model takes the farther surface.
/// Deterministic; does nothing for a sensor whose background is known.
class LiveBackground {
  public:
    struct Params {
        int every_frames = 10;  ///< framesets between two images that are learned from
        int images = 30;        ///< of a sensor, before its background is taken for known

        InvalidSettings validate() const;
    };

    LiveBackground(const std::vector<CalibratedSensor>& depth_sensors,
                   const std::vector<std::optional<DepthImage>>& known, Params params);

    /// One call a frameset, before the foreground is asked for.
    void update(const Frameset& frameset, ForegroundModel& foreground);

    /// Nothing is left to learn.
    bool done() const;

  private:
    Params params_;
    BackgroundLearner learner_;
    std::vector<int> missing_;  ///< images still wanted of each sensor
    int64_t framesets_ = 0;
};

}  // namespace deixis
