// Wires script, body, scenery and sensors together.
#include "appliance/simulation/virtual_cell.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "appliance/simulation/body_surface.h"
#include "appliance/simulation/cell_scenery.h"
#include "appliance/simulation/clip_motion.h"
#include "appliance/simulation/counter_random.h"
#include "appliance/simulation/depth_view.h"
#include "appliance/simulation/script_planner.h"
#include "appliance/simulation/sensor_noise.h"

namespace deixis {

const std::array<const char*, 15> simulated_joint_names = {
    "head",        "neck",       "left_shoulder", "right_shoulder", "left_elbow",
    "right_elbow", "left_wrist", "right_wrist",   "pelvis",         "left_hip",
    "right_hip",   "left_knee",  "right_knee",    "left_ankle",     "right_ankle"};

namespace {

constexpr uint64_t background_frames = uint64_t{1} << 32;  // noise of the empty cell is not that of any frame
constexpr int background_count = 9;

CalibratedSensor draw_sensor(const Scenario& scenario, const ScenarioSensor& given, uint64_t seed,
                             size_t index) {
    DrawSequence draw(seed, 100 + index);
    const ScenarioOptics& optics = scenario.optics;
    CalibratedSensor sensor;
    sensor.name = given.name;
    CameraModel& camera = sensor.camera;
    camera.width = optics.width;
    camera.height = optics.height;
    const double scale = optics.width / 640.0;
    camera.fx = optics.focal * scale * draw.uniform(0.985, 1.015);
    camera.fy = camera.fx * draw.uniform(0.998, 1.002);
    camera.cx = 0.5 * (optics.width - 1) + scale * draw.uniform(-6, 6);
    camera.cy = 0.5 * (optics.height - 1) + scale * draw.uniform(-6, 6);
    const std::array<double, 5> lens = {draw.uniform(-0.10, 0.06), draw.uniform(-0.03, 0.06),
                                        draw.uniform(-0.002, 0.002), draw.uniform(-0.002, 0.002),
                                        draw.uniform(-0.01, 0.01)};
    if (optics.distorted) camera.distortion = lens;

    Eigen::Vector3d position = given.position;
    for (int i = 0; i < 3; ++i) position[i] += optics.place_spread * draw.uniform(-1, 1);
    Eigen::Vector3d target = given.look_at;
    for (int i = 0; i < 3; ++i) target[i] += 0.5 * optics.place_spread * draw.uniform(-1, 1);
    const Eigen::Vector3d z = (target - position).normalized();
    const Eigen::Vector3d right = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d world_from_camera;
    world_from_camera << right, z.cross(right), z;
    world_from_camera =
        world_from_camera *
        Eigen::AngleAxisd(draw.uniform(-0.04, 0.04), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    sensor.camera_from_world = RigidTransform{world_from_camera, position}.inverse();
    return sensor;
}

/// A sensor's own clock as the session clock sees it.
struct SensorClock {
    double phase, period;  ///< [s]
    uint64_t jitter_stream;
};

struct SensorState {
    DepthView view;
    DepthLayer empty_cell;
    DepthLayer with_part;
    std::optional<FloorPose> part_at;  ///< the trolley's place in `with_part`
    DepthLayer whole;
    RayCaster body;
    std::vector<Eigen::Vector3f> vertices;
    SensorClock clock;
};

bool same_place(const FloorPose& a, const FloorPose& b) {
    return a.position == b.position && a.turn == b.turn;
}

}  // namespace

struct VirtualCell::Impl {
    Scenario scenario;
    uint64_t seed = 1;
    SensorRig rig;
    std::optional<SensorNoise> noise;
    CellScript script;
    SurfaceMesh load;  ///< part and trolley, trolley frame
    RayCaster scenery, part, load_caster;
    std::optional<BodySurface> body;
    std::optional<ClipMotion> clip;  ///< replaces the script's motion
    std::vector<SensorState> sensors;
    Eigen::Vector3d part_middle = Eigen::Vector3d::Zero();  ///< part frame
    int64_t session_start_us = 0;

    Impl() = default;

    Result<void> load_clip();
    Result<void> set_up(const Scenario& given, uint64_t with_seed, const SurfaceMesh& part_mesh);
    void set_up_sensors();
    bool shows_load(double time) const;
    bool in_cell(double time) const;
    BodyPlaces places(double time) const;
    void cast(SensorState& sensor, double time);
    double exposure(const SensorState& sensor, int64_t frame) const;
};

Result<void> VirtualCell::Impl::set_up(const Scenario& given, uint64_t with_seed,
                                       const SurfaceMesh& part_mesh) {
    scenario = given;
    seed = with_seed;
    scenery.add(scenery_mesh(scenario.cell, scenario.clutter, seed));
    scenery.commit();
    SurfaceMesh empty;
    const SurfaceMesh& used = scenario.part.present ? part_mesh : empty;
    if (scenario.part.present && used.triangles.empty())
        return fail(scenario.file.string() + ": key \"part.model\" names a file without surfaces");
    part.add(used);
    part.commit();
    auto planned = plan_script(scenario, seed, used, part);
    if (!planned) return tl::unexpected(planned.error());
    script = std::move(*planned);
    if (auto loaded = load_clip(); !loaded) return loaded;
    if (scenario.seconds > 0) script.duration = scenario.seconds;
    if (scenario.part.present) {
        load = used;
        for (Eigen::Vector3f& v : load.vertices)
            v = (script.trolley_from_part * v.cast<double>().eval()).cast<float>();
        const MeshBounds bounds = bounds_of(load);
        append(load, trolley_mesh(bounds));
        const MeshBounds own = bounds_of(used);
        part_middle = 0.5 * (own.min + own.max).cast<double>();
    }
    load_caster.add(load);
    load_caster.commit();
    if (scenario.worker.present) body.emplace(script.dimensions);
    set_up_sensors();
    return {};
}

Result<void> VirtualCell::Impl::load_clip() {
    const ScenarioWorker& worker = scenario.worker;
    if (worker.clip.empty()) return {};
    auto read = worker.skeleton.empty() ? read_bvh(worker.clip) : read_asf_amc(worker.skeleton, worker.clip);
    if (!read) return tl::unexpected(read.error());
    clip.emplace(script.dimensions, std::move(*read), script.worker.feet.end(), worker.clip_scale);
    script.duration = clip->duration_s();
    return {};
}

void VirtualCell::Impl::set_up_sensors() {
    DrawSequence draw(seed, 11);
    SensorNoiseParams published;
    published.level = scenario.optics.noise.value_or(draw.uniform(0.8, 1.2));
    noise.emplace(published);
    session_start_us = static_cast<int64_t>(draw.uniform(200'000, 3'000'000));
    rig.cell = scenario.cell;
    rig.pointing_axis = scenario.pointing_axis;
    for (size_t i = 0; i < scenario.sensors.size(); ++i) {
        rig.sensors.push_back(draw_sensor(scenario, scenario.sensors[i], seed, i));
        const double period = (1 + 1e-6 * draw.uniform(-60, 60)) / scenario.fps;
        SensorState s{DepthView(rig.sensors.back()),
                      {},
                      {},
                      {},
                      {},
                      {},
                      {},
                      {draw.uniform(0.1, 0.9) * period, period, 200 + i}};
        s.empty_cell = s.view.empty_layer();
        s.view.overlay(s.empty_cell, {&scenery, {}}, {}, s.view.whole());
        if (body) {
            s.body.add(body->rest_mesh());
            s.body.commit();
        }
        sensors.push_back(std::move(s));
    }
}

bool VirtualCell::Impl::in_cell(double time) const {
    if (!scenario.part.present) return false;
    const Eigen::Vector3d middle = script.surroundings(time).world_from_part * part_middle;
    return (middle.head<2>().array() >= scenario.cell.min.head<2>().array()).all() &&
           (middle.head<2>().array() <= scenario.cell.max.head<2>().array()).all();
}

BodyPlaces VirtualCell::Impl::places(double time) const {
    const BodyDimensions& d = script.dimensions;
    return place_body(d,
                      clip ? clip->at(time) : posture_at(d, script.worker, script.surroundings(time), time));
}

void VirtualCell::Impl::cast(SensorState& s, double time) {
    const ViewedObject scenery_view{&scenery, {}};
    ViewedObject load_view{&load_caster, {}};
    std::vector<ViewedObject> below{scenery_view};
    const DepthLayer* base = &s.empty_cell;
    if (scenario.part.present) {
        const FloorPose at = script.trolley.at(time).pose;
        load_view.world_from_object = world_from_floor_pose(at);
        if (!s.part_at || !same_place(*s.part_at, at)) {
            s.with_part = s.empty_cell;
            s.view.overlay(s.with_part, load_view, below,
                           s.view.footprint(load.vertices, load_view.world_from_object));
            s.part_at = at;
        }
        below.push_back(load_view);
        base = &s.with_part;
    }
    s.whole = *base;
    if (!body) return;
    body->move(places(time), s.vertices);
    s.body.update(0, s.vertices);
    s.body.commit();
    s.view.overlay(s.whole, {&s.body, {}}, below, s.view.footprint(s.vertices, {}));
}

double VirtualCell::Impl::exposure(const SensorState& s, int64_t frame) const {
    const double jitter =
        0.001 * CounterRandom(seed, s.clock.jitter_stream).normal(static_cast<uint64_t>(frame));
    return s.clock.phase + s.clock.period * static_cast<double>(frame) + std::clamp(jitter, -0.003, 0.003);
}

VirtualCell::VirtualCell(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VirtualCell::~VirtualCell() = default;
VirtualCell::VirtualCell(VirtualCell&&) noexcept = default;
VirtualCell& VirtualCell::operator=(VirtualCell&&) noexcept = default;

Result<VirtualCell> VirtualCell::create(const Scenario& scenario, uint64_t seed, const SurfaceMesh& part) {
    auto impl = std::make_unique<Impl>();
    if (const auto done = impl->set_up(scenario, seed, part); !done) return tl::unexpected(done.error());
    return VirtualCell(std::move(impl));
}

const SensorRig& VirtualCell::rig() const {
    return impl_->rig;
}
double VirtualCell::duration_s() const {
    return impl_->script.duration;
}

int64_t VirtualCell::frame_count(size_t sensor) const {
    const SensorClock& clock = impl_->sensors[sensor].clock;
    return std::max<int64_t>(
        0, static_cast<int64_t>((impl_->script.duration - clock.phase - 0.005) / clock.period));
}

FrameTiming VirtualCell::timing(size_t sensor, int64_t frame) const {
    const SensorState& s = impl_->sensors[sensor];
    FrameTiming timing;
    timing.time_s = impl_->exposure(s, frame);
    timing.timestamp_us = impl_->session_start_us + std::llround(1e6 * timing.time_s);
    // Arrival: 18 ms of exposure and transfer, and a scheduler's tail; the host counts from an epoch of its
    // own.
    const double late =
        CounterRandom(impl_->seed, s.clock.jitter_stream + 50).uniform(static_cast<uint64_t>(frame));
    timing.host_us = 1'700'000'000'000'000 + timing.timestamp_us + 18'000 +
                     std::llround(-1500 * std::log(1 - 0.999 * late));
    return timing;
}

void VirtualCell::render(size_t sensor, int64_t frame, DepthFrame& out) {
    SensorState& s = impl_->sensors[sensor];
    const FrameTiming when = timing(sensor, frame);
    impl_->cast(s, when.time_s);
    impl_->noise->apply(impl_->seed * 64 + sensor, static_cast<uint64_t>(frame), s.whole, s.view.width(),
                        s.view.height(), out.depth);
    out.present = true;
    out.timestamp_us = when.timestamp_us;
    out.host_us = when.host_us;
}

void VirtualCell::render_clean(size_t sensor, double time_s, DepthImage& out) {
    SensorState& s = impl_->sensors[sensor];
    impl_->cast(s, time_s);
    out.resize(s.view.width(), s.view.height());
    for (size_t i = 0; i < out.millimetres.size(); ++i) {
        const float mm = 1000 * s.whole.z[i];
        out.millimetres[i] = mm < 65534 ? static_cast<uint16_t>(std::lround(mm)) : 0;
    }
}

DepthImage VirtualCell::background(size_t sensor) {
    const SensorState& s = impl_->sensors[sensor];
    std::array<DepthImage, background_count> frames;
    for (int i = 0; i < background_count; ++i)
        impl_->noise->apply(impl_->seed * 64 + sensor, background_frames + static_cast<uint64_t>(i),
                            s.empty_cell, s.view.width(), s.view.height(), frames[i]);
    DepthImage middle = frames[0];
    std::vector<uint16_t> seen;
    for (size_t p = 0; p < middle.millimetres.size(); ++p) {
        seen.clear();
        for (const DepthImage& frame : frames)
            if (frame.millimetres[p] != 0) seen.push_back(frame.millimetres[p]);
        std::sort(seen.begin(), seen.end());
        middle.millimetres[p] = seen.size() > background_count / 2 ? seen[seen.size() / 2] : 0;
    }
    return middle;
}

CellTruth VirtualCell::truth(double time_s) const {
    CellTruth truth;
    if (impl_->in_cell(time_s)) truth.world_from_part = impl_->script.surroundings(time_s).world_from_part;
    if (!impl_->scenario.worker.present) return truth;
    const BodyPlaces places = impl_->places(time_s);
    truth.joints = places.joints;
    truth.fingertips = places.fingertips;
    truth.eye = places.eye;
    for (const HeldGesture& g : impl_->script.gestures)
        if (time_s >= g.t0 && time_s <= g.t1) truth.pointing = g.pointing;
    return truth;
}

std::string VirtualCell::description() const {
    std::ostringstream out;
    const CellScript& s = impl_->script;
    out.precision(3);
    out << s.duration << " s";
    if (impl_->scenario.worker.present)
        out << ", worker " << s.dimensions.height << " m, build " << s.dimensions.girth << ", aims by "
            << name_of(s.aim);
    const auto meant = std::count_if(s.gestures.begin(), s.gestures.end(),
                                     [](const HeldGesture& g) { return g.pointing.meant; });
    out << ", " << meant << " meant gestures, " << static_cast<long>(s.gestures.size()) - meant
        << " traps, noise " << impl_->noise->params().level;
    return out.str();
}

}  // namespace deixis
