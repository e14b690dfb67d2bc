// Gathers rig, background, part and frame sources from a session folder or from single files.
#include "appliance/station/work_cell.h"

#include <algorithm>

#include "appliance/calibration/calibration_file.h"
#include "appliance/records/utc_time.h"
#include "appliance/sessions/depth_png.h"
#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/session.h"
#include "tracking/volume/background_learner.h"

namespace deixis {
namespace {

/// Enough images for a stable mode a pixel, whatever the length of the session.
constexpr int64_t learning_images = 120;

Result<std::optional<KnownPart>> load_part(const std::filesystem::path& part_toml,
                                           const ReferenceModelParams& reference, const ModelReader& reader,
                                           std::vector<std::string>& warnings) {
    auto file = read_part_file(part_toml);
    if (!file) return tl::unexpected(file.error());
    warnings.insert(warnings.end(), file->warnings.begin(), file->warnings.end());
    auto mesh = load_mesh(file->model, file->metres_per_unit, reader);
    if (!mesh) return tl::unexpected(mesh.error());
    auto model = ReferenceModel::build(*mesh, reference);
    if (!model) return fail(file->model.string() + ": " + model.error().sentence);
    return KnownPart{std::move(*file), std::move(*mesh), std::move(*model)};
}

SensorRig depth_sensors_of(const SensorRig& rig) {
    SensorRig depth{{}, rig.cell, rig.pointing_axis};
    for (const CalibratedSensor& sensor : rig.sensors)
        if (sensor.kind == SensorKind::depth) depth.sensors.push_back(sensor);
    return depth;
}

/// Fills the missing images of `cell.background` from the session's own frames.
Result<void> learn_background(WorkCell& cell, const Progress& progress) {
    BackgroundLearner learner(cell.rig.sensors, {});
    for (size_t s = 0; s < cell.sensors.size(); ++s) {
        if (cell.background[s]) continue;
        const SensorSpec& sensor = cell.sensors[s];
        const int64_t step = std::max<int64_t>(1, sensor.frames / learning_images);
        const auto read = read_oni(sensor.uri, [&](int64_t frame, int64_t, const DepthImage& image) {
            if (frame % step == 0) learner.add(s, image);
            if (progress && frame % 100 == 0)
                progress(
                    "learning the empty cell of " + sensor.name,
                    static_cast<double>(frame) / static_cast<double>(std::max<int64_t>(1, sensor.frames)));
            return true;
        });
        if (!read) return tl::unexpected(read.error());
    }
    const auto learned = learner.background();
    for (size_t s = 0; s < cell.background.size(); ++s)
        if (!cell.background[s]) cell.background[s] = learned[s];
    return {};
}

/// Session stamps of the frames of a stream that the station does not look at.
Result<std::vector<int64_t>> stamps_of(const SessionStream& stream, SensorKind kind) {
    std::vector<int64_t> stamps;
    if (kind == SensorKind::video) {
        auto video = open_video_stream(stream);
        if (!video) return tl::unexpected(video.error());
        stamps = std::move(video->timestamp_us);
    } else {
        const auto read = read_oni(stream.file, [&](int64_t, int64_t timestamp_us, const DepthImage&) {
            stamps.push_back(timestamp_us);
            return true;
        });
        if (!read) return tl::unexpected(read.error());
    }
    for (int64_t& stamp : stamps) stamp += stream.start_us;
    return stamps;
}

SensorSpec spec_of(const CalibratedSensor& sensor) {
    SensorSpec spec;
    spec.name = sensor.name;
    spec.uri = sensor.uri;
    spec.width = sensor.camera.width;
    spec.height = sensor.camera.height;
    return spec;
}

}  // namespace

Result<WorkCell> work_cell_of_session(const std::filesystem::path& folder,
                                      const ReferenceModelParams& reference, const ModelReader& reader,
                                      const Progress& progress) {
    auto session = open_session(folder);
    if (!session) return tl::unexpected(session.error());
    WorkCell cell;
    cell.source = session->name;
    cell.rig = depth_sensors_of(session->rig);
    cell.settings = session->settings;
    cell.warnings = session->warnings;
    if (cell.rig.sensors.empty())
        return fail((folder / "calibration.toml").string() + ": no sensor of kind \"depth\"");
    if (const auto created = parse_utc(session->created)) cell.epoch_us = *created;
    for (const CalibratedSensor& sensor : cell.rig.sensors) {
        const auto stream = std::find_if(session->streams.begin(), session->streams.end(),
                                         [&](const SessionStream& s) { return s.sensor == sensor.name; });
        if (stream == session->streams.end())
            return fail((folder / "session.toml").string() + ": no stream for sensor \"" + sensor.name +
                        "\"");
        SensorSpec spec = spec_of(sensor);
        spec.uri = stream->file.string();
        spec.recording = true;
        spec.start_us = stream->start_us;
        spec.frames = stream->frames;
        cell.sensors.push_back(spec);
    }
    // The first sensor clocks the framesets, whatever it sees (formats.md).
    if (const SensorKind kind = session->rig.sensors.front().kind; kind != SensorKind::depth) {
        auto stamps = stamps_of(session->streams.front(), kind);
        if (!stamps) return tl::unexpected(stamps.error());
        cell.clock_us = std::move(*stamps);
    }
    cell.frames = session->streams.front().frames;
    cell.start_us = cell.sensors.front().start_us;
    for (const SensorSpec& sensor : cell.sensors) cell.start_us = std::min(cell.start_us, sensor.start_us);
    auto background = read_background(*session);
    if (!background) return tl::unexpected(background.error());
    cell.background = std::move(*background);
    if (auto learned = learn_background(cell, progress); !learned) return tl::unexpected(learned.error());
    if (session->part) {
        auto part = load_part(*session->part, reference, reader, cell.warnings);
        if (!part) return tl::unexpected(part.error());
        cell.part = std::move(*part);
    }
    return cell;
}

Result<WorkCell> work_cell_of_files(const std::filesystem::path& calibration,
                                    const std::filesystem::path& part_file,
                                    const std::filesystem::path& background_folder,
                                    const ReferenceModelParams& reference, const ModelReader& reader) {
    auto file = read_calibration(calibration);
    if (!file) return tl::unexpected(file.error());
    WorkCell cell;
    cell.source = "live";
    cell.rig = depth_sensors_of(file->rig);
    cell.warnings = file->warnings;
    if (cell.rig.sensors.empty()) return fail(calibration.string() + ": no sensor of kind \"depth\"");
    for (const CalibratedSensor& sensor : cell.rig.sensors) {
        if (sensor.uri.empty())
            return fail(calibration.string() + ": sensor \"" + sensor.name +
                        "\" has no uri, expected the live device it belongs to");
        cell.sensors.push_back(spec_of(sensor));
        const std::filesystem::path image = background_folder / (sensor.name + ".png");
        if (background_folder.empty() || !std::filesystem::exists(image)) {
            cell.warnings.push_back("no background image for sensor \"" + sensor.name +
                                    "\": all that it sees counts as foreground until it is learned");
            cell.background.emplace_back();
            continue;
        }
        auto depth = read_depth_png(image, {sensor.camera.width, sensor.camera.height});
        if (!depth) return tl::unexpected(depth.error());
        cell.background.emplace_back(std::move(*depth));
    }
    if (!part_file.empty()) {
        auto part = load_part(part_file, reference, reader, cell.warnings);
        if (!part) return tl::unexpected(part.error());
        cell.part = std::move(*part);
    }
    return cell;
}

}  // namespace deixis
