// A scenario as a value: what stands in SCENARIO.toml, checked. What is absent there is drawn from the seed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tracking/geometry/result.h"
#include "tracking/geometry/sensor_rig.h"

namespace deixis {

/// Which line of the worker's goes through the spot that he means.
enum class AimMode { eye, forearm, finger };

/// "eye", "forearm" or "finger".
const char* name_of(AimMode mode);

/// Place of the trolley (or of the worker) on the floor, world frame.
struct FloorPose {
    Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< [m]
    double turn = 0;                                     ///< about Z [rad]
};

struct ScenarioPart {
    std::filesystem::path model;  ///< CAD file, resolved against the scenario's folder; empty with `sample`
    std::string sample;           ///< "a" or "b": a bumper of our own making instead of a file
    std::string units = "mm";     ///< of the model file: "mm" or "m"
    std::string type = "part";
    std::string serial = "0001";
    Eigen::Matrix3d mounting = Eigen::Matrix3d::Identity();  ///< trolley_from_part, rotation
    std::optional<Eigen::Vector3d>
        mounting_position;     ///< part origin in the trolley frame; absent: centred, see below
    double lower_edge = 0.55;  ///< height of the part's lowest point where mounting_position is absent [m]
    FloorPose start;           ///< of the trolley
    bool present = true;       ///< false: no part and no trolley at all
    struct ZoneBox {
        std::string name;
        Box box;
    };
    std::vector<ZoneBox> zones;  ///< copied to part.toml
};

struct ScenarioSensor {
    std::string name;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world [m], before the seed shifts it
    Eigen::Vector3d look_at = Eigen::Vector3d::Zero();   ///< world [m]
};

struct ScenarioOptics {
    int width = 640, height = 480;
    double focal = 575.8;         ///< nominal, of a 640 pixel wide image [pixel]
    std::optional<double> noise;  ///< 1 = as published, 0 = none; absent: drawn 0.8 to 1.2
    bool distorted = true;        ///< draw a Brown-Conrady lens
    double place_spread = 0.12;   ///< the seed shifts each sensor by up to this much along each axis [m]
};

struct ScenarioWorker {
    bool present = true;
    std::optional<double> height;  ///< [m]; absent: drawn 1.55 to 1.95
    std::optional<double> build;   ///< girth factor; absent: drawn 0.9 to 1.18
    std::optional<AimMode> aim;    ///< absent: drawn
    double scatter = 0.0175;       ///< standard deviation of the aimed line's direction, each axis [rad]
    double gap_min = 0.05, gap_max = 0.15;  ///< fingertip to surface while pointing [m]
    std::optional<FloorPose>
        start;  ///< absent: at the trolley's end when it is pushed first, else before the part
    std::filesystem::path clip;      ///< BVH or AMC file whose motion replaces the actions; empty = none
    std::filesystem::path skeleton;  ///< ASF file of an AMC clip
    double clip_scale = 0;           ///< metres per unit of the clip; 0 = by the clip's leg length
};

enum class ActionKind { wait, walk, push, point, pass, hip, scratch, lean };

struct ScenarioAction {
    ActionKind kind = ActionKind::wait;
    std::optional<double> seconds;          ///< of the hold, wait or push; absent: drawn
    FloorPose to;                           ///< walk: the worker; push: the trolley
    std::optional<Eigen::Vector3d> target;  ///< part frame [m]; absent: drawn on the outer skin
    std::optional<bool> left_arm;           ///< absent: drawn
    bool meant = true;
    bool touch = false;
    bool by_end = true;     ///< push with both hands from the end, else one hand at the corner
    bool pointing = false;  ///< push: the free hand points meanwhile (a trap)
};

struct Scenario {
    std::filesystem::path file;
    std::string name;
    uint64_t seed = 1;
    double fps = 30;
    double seconds = 0;  ///< whole length; 0 = as long as the actions or the clip last
    double tail = 1.0;   ///< after the last action [s]
    Box cell{{-2, -1.5, 0}, {2, 1.5, 2.2}};
    Eigen::Vector3d pointing_axis{0, 1, 0};
    bool clutter = true;
    ScenarioPart part;
    ScenarioOptics optics;
    std::vector<ScenarioSensor> sensors;
    ScenarioWorker worker;
    std::vector<ScenarioAction> actions;
    std::vector<std::pair<std::string, double>> expected;  ///< keys of expected.toml as they stand
    std::vector<std::string> warnings;                     ///< unknown keys, one sentence each
};

/// Reads and checks `path` (format "deixis-scenario/1"). Refuses with one sentence that names file and key:
/// what does not parse, is missing, mistyped, out of range or contradictory. Unknown keys become warnings.
Result<Scenario> read_scenario(const std::filesystem::path& path);

/// The same from text; `path` is used in sentences and to resolve relative files.
Result<Scenario> parse_scenario(const std::string& text, const std::filesystem::path& path);

}  // namespace deixis
