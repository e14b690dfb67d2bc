// What the screen shows besides the live stream, asked for when a browser asks: the part, the cell, the
// marks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

struct ScreenZone {
    std::string name;
    Box box;  ///< part frame [m]
};

/// The part as the browser draws it: outer skin in the part frame [m].
struct ScreenPart {
    std::string type;
    std::string serial;
    std::vector<ScreenZone> zones;
    SurfaceMesh mesh;
};

/// Filled by `commands`. Called on the server's one thread, so every answer must come within a few
/// milliseconds and from any thread's point of view be safe: hand out what is in memory, query nothing that
/// may block. A returned object must not change any more; a new state is a new object.
class ScreenFeed {
  public:
    virtual ~ScreenFeed() = default;

    /// The part in the cell; null while none is known.
    virtual std::shared_ptr<const ScreenPart> part() = 0;

    /// The calibrated sensors, for the cell view; null while unknown.
    virtual std::shared_ptr<const SensorRig> rig() = 0;

    /// The marks of the part in the cell as a JSON array, oldest first, withdrawn ones included:
    /// `[{"id", "position_part": [x, y, z], "normal_part": [x, y, z], "zone", "arm", "time" (RFC 3339 UTC),
    /// "confidence", "state" ("open", "confirmed", "withdrawn"), "touch"}]`. A failure is answered as 503.
    virtual Result<std::string> marks_json() = 0;
};

}  // namespace deixis
