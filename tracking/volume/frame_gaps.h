// Gaps in framesets: a sensor whose frame came a little too far off is seen by that frame. In, out:
// framesets.
#pragma once

#include <cstdint>
#include <vector>

#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// Two sensors of less than 30 frames a second can run half a period apart for hours: no frame of the one has
/// a partner within 17 ms, and a station that takes this for a missing sensor is blind on that side. Such a
/// gap is filled with the frame that the pairing found beyond its window while that is near in time; a sensor
/// that is gone stays absent. Deterministic; no allocation once warm.
class FrameGaps {
  public:
    struct Params {
        int reach_ms = 40;  ///< farthest frame that fills a gap, before or after the frameset's stamp [ms]

        InvalidSettings validate() const;
    };

    explicit FrameGaps(Params params) : params_(params) {}

    /// `frameset`, or a copy with its gaps filled; the stamps of the filled-in frames are their own. Valid
    /// until the next update and as long as `frameset`.
    const Frameset& update(const Frameset& frameset);
    const Frameset& update(Frameset&&) = delete;

  private:
    bool fills(const DepthFrame& frame, int64_t timestamp_us) const;

    Params params_;
    Frameset filled_;
};

}  // namespace deixis
