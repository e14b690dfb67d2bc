// What a station has to know before its first frame: the depth sensors, the empty cell, the part, where
// frames come from.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "appliance/parts/model_reader.h"
#include "appliance/parts/part_model.h"
#include "appliance/sensors/frame_source.h"
#include "tracking/geometry/depth_image.h"
#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"
#include "tracking/part/reference_model.h"

namespace deixis {

struct KnownPart {
    PartFile file;
    SurfaceMesh mesh;  ///< part frame [m]
    std::shared_ptr<const ReferenceModel> model;
};

struct WorkCell {
    std::string source;                                 ///< "live", or the session's name
    SensorRig rig;                                      ///< depth sensors only, in the calibration's order
    std::vector<std::optional<DepthImage>> background;  ///< one a sensor of `rig`
    std::optional<KnownPart> part;
    std::vector<SensorSpec> sensors;  ///< one a sensor of `rig`
    int64_t frames = -1;              ///< framesets to come; -1 = unknown (live)
    std::vector<int64_t> clock_us;    ///< their stamps, where the first sensor gives no depth; else empty
    int64_t epoch_us = 0;             ///< UTC of session time `start_us`; 0 for live
    int64_t start_us = 0;             ///< the earliest of the sensors' starts; stamps may count from anywhere
    std::optional<std::filesystem::path> settings;
    std::vector<std::string> warnings;
};

/// Called now and then while something takes long: what, and the share done (0 to 1).
using Progress = std::function<void(const std::string& what, double share)>;

/// From a session folder. Without a background in it, one is learned from its own frames (formats.md).
/// Refuses what `open_session`, `read_part_file` and `load_mesh` refuse, and a session without depth stream.
Result<WorkCell> work_cell_of_session(const std::filesystem::path& folder,
                                      const ReferenceModelParams& reference, const ModelReader& reader,
                                      const Progress& progress);

/// From files, for live sensors: each depth sensor's `uri` in the calibration names its device; `part_file`
/// and `background_folder` may be empty. A missing background image is a warning: all that is seen is then
/// foreground.
Result<WorkCell> work_cell_of_files(const std::filesystem::path& calibration,
                                    const std::filesystem::path& part_file,
                                    const std::filesystem::path& background_folder,
                                    const ReferenceModelParams& reference, const ModelReader& reader);

}  // namespace deixis
