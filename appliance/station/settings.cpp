// Binds every Params struct of the program to its section of settings.toml.
#include "appliance/station/settings.h"

#include <fstream>
#include <iterator>
#include <set>

namespace deixis {
namespace {

constexpr std::uintmax_t largest_settings_file = 1 << 20;

template <class P>
SettingSection section(const char* name, P& params, std::vector<SettingField> fields) {
    return {name, std::move(fields), [&params] { return params.validate(); }};
}

/// One of several sections that hold the fields of `params`: each names only what stands in it.
template <class P>
SettingSection shared_section(const char* name, P& params, std::vector<SettingField> fields) {
    std::set<std::string> keys;
    for (const SettingField& field : fields) keys.insert(field.key);
    return {name, std::move(fields), [&params, keys = std::move(keys)] {
                InvalidSettings complaints = params.validate();
                std::erase_if(complaints, [&](const InvalidSetting& c) { return !keys.contains(c.key); });
                return complaints;
            }};
}

SettingSection foreground_section(ForegroundModel::Params& p) {
    return section("foreground", p,
                   {{"base_mm", &p.base_mm},
                    {"step_per_m2", &p.step_per_m2},
                    {"threshold_steps", &p.threshold_steps},
                    {"moved_frames", &p.moved_frames},
                    {"drift_rate", &p.drift_rate},
                    {"hole_pixels", &p.hole_pixels},
                    {"neighbours", &p.neighbours}});
}

SettingSection surface_section(SurfaceFusion::Params& p) {
    return section("surface", p,
                   {{"stride", &p.stride},
                    {"floor_m", &p.floor_m},
                    {"max_depth_m", &p.max_depth_m},
                    {"normal_reach", &p.normal_reach},
                    {"step_per_m2", &p.step_per_m2},
                    {"edge_steps", &p.edge_steps}});
}

SettingSection part_section(PartTracker::Params& p) {
    return section("part", p,
                   {{"search_period", &p.search_period},
                    {"max_tilt_deg", &p.max_tilt_deg},
                    {"found_fitness", &p.found_fitness},
                    {"found_residual", &p.found_residual},
                    {"held_fitness", &p.held_fitness},
                    {"held_residual", &p.held_residual},
                    {"found_share_min", &p.found_share_min},
                    {"held_share_min", &p.held_share_min},
                    {"seen_through_max", &p.seen_through_max},
                    {"rival_margin", &p.rival_margin},
                    {"lock_min", &p.lock_min},
                    {"confirm_frames", &p.confirm_frames},
                    {"lost_frames", &p.lost_frames},
                    {"rest_s", &p.rest_s},
                    {"rest_mm", &p.rest_mm},
                    {"motion_mm", &p.motion_mm},
                    {"icp_points", &p.icp_points}});
}

SettingSection reference_section(ReferenceModelParams& p) {
    return section("reference", p,
                   {{"fine_spacing", &p.fine_spacing},
                    {"coarse_spacing", &p.coarse_spacing},
                    {"descriptor_radius", &p.descriptor_radius},
                    {"grid_cell", &p.grid_cell},
                    {"reach", &p.reach}});
}

SettingSection carving_section(VoxelCarver::Params& p) {
    return section("carving", p,
                   {{"voxel_m", &p.voxel_m},
                    {"penetration_m", &p.penetration_m},
                    {"slack_m", &p.slack_m},
                    {"step_per_m2", &p.step_per_m2},
                    {"slack_steps", &p.slack_steps}});
}

SettingSection worker_section(WorkerVolume::Params& p) {
    return section("worker", p,
                   {{"min_height_m", &p.min_height_m},
                    {"max_height_m", &p.max_height_m},
                    {"attach_m", &p.attach_m},
                    {"clutter_s", &p.clutter_s},
                    {"min_voxels", &p.min_voxels}});
}

/// What a plant sets stands in [gesture]; how the stages do it in sections of their own.
SettingSection gesture_section(GestureTracker::Params& p) {
    return shared_section("gesture", p,
                          {{"dwell_s", &p.stillness.dwell_s},
                           {"eye_weight", &p.pointing.eye_weight},
                           {"max_reach_m", &p.pointing.max_reach_m},
                           {"touch_m", &p.pointing.touch_m},
                           {"reach_out_m", &p.reach_out_m}});
}

SettingSection limb_section(LimbFinder::Params& p) {
    return section(
        "limb", p,
        {{"min_length_m", &p.min_length_m}, {"max_length_m", &p.max_length_m}, {"bridge_m", &p.bridge_m}});
}

SettingSection arm_section(ArmFinder::Params& p) {
    return section("arm", p,
                   {{"min_length_m", &p.min_length_m},
                    {"forearm_of_height", &p.forearm_of_height},
                    {"max_width_m", &p.max_width_m},
                    {"min_off_trunk_m", &p.min_off_trunk_m},
                    {"min_tip_height_m", &p.min_tip_height_m},
                    {"steepest_down", &p.steepest_down},
                    {"eye_of_height", &p.eye_of_height}});
}

SettingSection pointing_section(PointingParams& p) {
    return shared_section("pointing", p,
                          {{"snap_m", &p.snap_m},
                           {"tip_sigma_m", &p.tip_sigma_m},
                           {"direction_sigma_deg", &p.direction_sigma_deg},
                           {"closeness_m", &p.closeness_m}});
}

SettingSection stillness_section(DwellDetector::Params& p) {
    return shared_section("stillness", p,
                          {{"slow_ends_s", &p.slow_ends_s},
                           {"gap_s", &p.gap_s},
                           {"across_radius_m", &p.across_radius_m},
                           {"across_drift_m", &p.across_drift_m},
                           {"along_drift_m", &p.along_drift_m},
                           {"spot_radius_m", &p.spot_radius_m},
                           {"spot_drift_m", &p.spot_drift_m},
                           {"steady_share", &p.steady_share},
                           {"away_m", &p.away_m},
                           {"away_s", &p.away_s},
                           {"gone_s", &p.gone_s}});
}

SettingSection recorder_section(MarkRecorderParams& p) {
    return section("recorder", p,
                   {{"queue_length", &p.queue_length},
                    {"retry_first_ms", &p.retry_first_ms},
                    {"retry_longest_ms", &p.retry_longest_ms},
                    {"stop_patience_ms", &p.stop_patience_ms}});
}

SettingSection plc_section(PlcParams& p) {
    return section("plc", p,
                   {{"mode", &p.mode},
                    {"address", &p.address},
                    {"port", &p.port},
                    {"allowed", &p.allowed},
                    {"max_connections", &p.max_connections},
                    {"request_timeout_ms", &p.request_timeout_ms},
                    {"idle_timeout_ms", &p.idle_timeout_ms},
                    {"unit", &p.unit},
                    {"to_plc_address", &p.to_plc_address},
                    {"from_plc_address", &p.from_plc_address},
                    {"cycle_ms", &p.cycle_ms},
                    {"answer_timeout_ms", &p.answer_timeout_ms},
                    {"reconnect_first_ms", &p.reconnect_first_ms},
                    {"reconnect_longest_ms", &p.reconnect_longest_ms},
                    {"heartbeat_timeout_ms", &p.heartbeat_timeout_ms},
                    {"stale_ms", &p.stale_ms},
                    {"queue_length", &p.queue_length}});
}

}  // namespace

InvalidSettings StationFiles::validate() const {
    InvalidSettings complaints;
    if (database.empty()) complaints.push_back({"database", "empty", "a file name"});
    return complaints;
}

InvalidSettings ScreenSettings::validate() const {
    InvalidSettings complaints;
    if (host != "127.0.0.1" && host != "::1" && host != "localhost")
        complaints.push_back({"host", "\"" + host + "\"", "\"127.0.0.1\", \"::1\" or \"localhost\""});
    require_range(complaints, "port", port, 0, 65535);
    return complaints;
}

InvalidSettings SensorSettings::validate() const {
    InvalidSettings complaints;
    require_range(complaints, "stall_limit_ms", stall_limit_ms, 200, 60'000);
    require_range(complaints, "pair_patience_ms", pair_patience_ms, 1, 1'000);
    require_range(complaints, "restart_delay_ms", restart_delay_ms, 10, 60'000);
    return complaints;
}

SettingsTable settings_table(Settings& s) {
    return {
        section("station", s.station,
                {{"calibration", &s.station.calibration},
                 {"part", &s.station.part},
                 {"background", &s.station.background},
                 {"database", &s.station.database},
                 {"driver_folder", &s.station.driver_folder}}),
        section("sensors", s.sensors,
                {{"stall_limit_ms", &s.sensors.stall_limit_ms},
                 {"pair_patience_ms", &s.sensors.pair_patience_ms},
                 {"restart_delay_ms", &s.sensors.restart_delay_ms}}),
        section("pairing", s.perception.gaps, {{"reach_ms", &s.perception.gaps.reach_ms}}),
        foreground_section(s.perception.foreground),
        surface_section(s.perception.surface),
        carving_section(s.perception.carving),
        worker_section(s.perception.worker),
        section("model", s.model,
                {{"time_limit_s", &s.model.time_limit_s}, {"memory_limit_mb", &s.model.memory_limit_mb}}),
        reference_section(s.reference),
        part_section(s.perception.part),
        section("perception", s.perception,
                {{"part_margin_m", &s.perception.part_margin_m}, {"threads", &s.perception.threads}}),
        gesture_section(s.perception.gesture),
        limb_section(s.perception.gesture.limbs),
        arm_section(s.perception.gesture.arms),
        pointing_section(s.perception.gesture.pointing),
        stillness_section(s.perception.gesture.stillness),
        section("record", s.ledger,
                {{"busy_timeout_ms", &s.ledger.busy_timeout_ms}, {"check_on_open", &s.ledger.check_on_open}}),
        recorder_section(s.recorder),
        plc_section(s.plc),
        section("screen", s.screen,
                {{"enabled", &s.screen.enabled},
                 {"host", &s.screen.host},
                 {"port", &s.screen.port},
                 {"web_root", &s.screen.web_root}})};
}

Result<SettingsFile> parse_settings(std::string_view text, const std::string& name) {
    SettingsFile file;
    if (auto applied = apply_settings(settings_table(file.settings), text, name, file.warnings); !applied)
        return tl::unexpected(applied.error());
    return file;
}

Result<SettingsFile> read_settings(const std::filesystem::path& path) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path, error);
    if (error) return fail(path.string() + ": cannot be read, expected a settings file");
    if (size > largest_settings_file)
        return fail(path.string() + ": holds " + std::to_string(size) +
                    " bytes, expected at most 1 MB of settings");
    std::ifstream in(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!in.good() && !in.eof()) return fail(path.string() + ": cannot be read, expected a settings file");
    auto file = parse_settings(text, path.string());
    if (!file) return file;
    const std::filesystem::path base = path.parent_path();
    for (std::string* entry : {&file->settings.station.calibration, &file->settings.station.part,
                               &file->settings.station.background, &file->settings.station.database,
                               &file->settings.station.driver_folder})
        if (!entry->empty() && std::filesystem::path(*entry).is_relative()) *entry = (base / *entry).string();
    return file;
}

}  // namespace deixis
