// A recording played over and over by the host's clock. Frames of an .oni file in, each handed out when it is
// due.
#pragma once

#include <cstdint>
#include <functional>
#include <thread>

#include "appliance/simulation/driver/virtual_plan.h"
#include "tracking/geometry/depth_image.h"

namespace deixis {

/// Frame k of round l is due when the host's steady clock shows l * period + start + its stamp: sensors in
/// different processes stay in step, as two cameras that look at one cell. Frames that are already past are
/// left out.
class VirtualPlayback {
  public:
    /// Called on the player's thread; `due_us` on the host's clock, the image is valid during the call.
    using Send = std::function<void(int64_t due_us, const DepthImage& image)>;

    ~VirtualPlayback() { stop(); }
    void start(const VirtualSensor& sensor, Send send);
    void stop();  ///< returns when the last call has returned

  private:
    std::jthread player_;
};

}  // namespace deixis
