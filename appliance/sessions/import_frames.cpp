// A frames folder (PNG images from anywhere, formats "A frames folder") made into a session folder.
#include "appliance/sessions/import_frames.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "appliance/calibration/calibration_file.h"
#include "appliance/calibration/toml_section.h"
#include "appliance/calibration/whole_file.h"
#include "appliance/sessions/depth_png.h"
#include "appliance/sessions/frame_stamps.h"
#include "appliance/sessions/session_file.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;

constexpr size_t largest_truth = size_t{1} << 30;

bool is_image_name(const std::string& name) {
    return name.size() >= 10 && name.ends_with(".png") &&
           name.find_first_not_of("0123456789") == name.size() - 4;
}

/// How many images stand in a sensor's folder; every other file there but timestamps.csv is a warning.
Result<int64_t> count_images(const fs::path& folder, std::vector<std::string>& warnings) {
    std::error_code error;
    std::vector<std::string> others;
    int64_t images = 0;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        if (is_image_name(name)) {
            ++images;
        } else if (name != "timestamps.csv") {
            others.push_back(entry.path().string() +
                             ": is left out, being neither timestamps.csv nor a frame");
        }
    }
    if (error) return fail(folder.string() + ": expected a folder of frames: " + error.message());
    std::sort(others.begin(), others.end());
    warnings.insert(warnings.end(), others.begin(), others.end());
    return images;
}

/// truth.jsonl line by line: each an object with an integer timestamp_us.
Result<void> check_truth(const fs::path& path) {
    const Result<std::string> text = read_whole_file(path, largest_truth);
    if (!text) return tl::unexpected(text.error());
    size_t number = 0;
    for (size_t at = text->starts_with("\xEF\xBB\xBF") ? 3 : 0; at < text->size();) {
        const size_t end = std::min(text->find('\n', at), text->size());
        const std::string_view line = std::string_view(*text).substr(at, end - at);
        at = end + 1;
        ++number;
        if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
        const nlohmann::json object = nlohmann::json::parse(line, nullptr, false);
        const std::string place = path.string() + ": line " + std::to_string(number);
        if (!object.is_object()) return fail(place + ": expected one JSON object");
        const auto stamp = object.find("timestamp_us");
        if (stamp == object.end() || !stamp->is_number_integer())
            return fail(place + ": key 'timestamp_us': expected a whole number of microseconds");
    }
    return {};
}

Result<void> check_toml(const fs::path& path) {
    const Result<std::string> text = read_whole_file(path, largest_toml);
    if (!text) return tl::unexpected(text.error());
    const Result<toml::table> table = parse_toml(*text, path.string());
    return table ? Result<void>{} : tl::unexpected(table.error());
}

/// One import: the folder it reads, the writer it fills.
class FramesImport {
  public:
    FramesImport(const fs::path& folder, const SensorRig& rig, SessionWriter& writer, ImportReport& report)
        : folder_(folder), rig_(rig), writer_(writer), report_(report) {}

    Result<void> run() {
        if (auto done = writer_.copy_calibration(folder_ / "calibration.toml"); !done) return done;
        if (auto done = copy_side_files(); !done) return done;
        warn_of_strangers();
        for (size_t sensor = 0; sensor < rig_.sensors.size(); ++sensor) {
            if (auto done = copy_background(sensor); !done) return done;
            if (auto done = copy_frames(sensor); !done) return done;
        }
        return {};
    }

  private:
    bool has(const char* name) const {
        std::error_code error;
        return fs::exists(folder_ / name, error);
    }

    Result<void> copy_side_files() {
        if (has("part.toml"))
            if (auto done = writer_.copy_part(folder_ / "part.toml"); !done) return done;
        if (has("truth.jsonl")) {
            if (auto done = check_truth(folder_ / "truth.jsonl"); !done) return done;
            if (auto done = writer_.copy_truth(folder_ / "truth.jsonl"); !done) return done;
        }
        if (has("expected.toml")) {
            if (auto done = check_toml(folder_ / "expected.toml"); !done) return done;
            if (auto done = writer_.copy_expected(folder_ / "expected.toml"); !done) return done;
        }
        if (!has("settings.toml")) return {};
        if (auto done = check_toml(folder_ / "settings.toml"); !done) return done;
        return writer_.copy_settings(folder_ / "settings.toml");
    }

    /// A folder that looks like a sensor's but is none is most likely a mistake.
    void warn_of_strangers() {
        std::error_code error;
        std::set<std::string> strangers;
        for (const auto& entry : fs::directory_iterator(folder_, error)) {
            const std::string name = entry.path().filename().string();
            const auto is_it = [&](const CalibratedSensor& sensor) { return sensor.name == name; };
            if (!entry.is_directory(error) || name == "background") continue;
            if (std::any_of(rig_.sensors.begin(), rig_.sensors.end(), is_it)) continue;
            strangers.insert(entry.path().string() + ": is left out, being no sensor of calibration.toml");
        }
        report_.warnings.insert(report_.warnings.end(), strangers.begin(), strangers.end());
    }

    Result<void> copy_background(size_t index) {
        const CalibratedSensor& sensor = rig_.sensors[index];
        const fs::path file = folder_ / "background" / (sensor.name + ".png");
        std::error_code error;
        if (sensor.kind != SensorKind::depth || !fs::exists(file, error)) return {};
        const Result<DepthImage> image = read_depth_png(file, {sensor.camera.width, sensor.camera.height});
        if (!image) return tl::unexpected(image.error());
        return writer_.set_background(index, *image);
    }

    Result<void> copy_frames(size_t index) {
        const CalibratedSensor& sensor = rig_.sensors[index];
        const fs::path folder = folder_ / sensor.name;
        std::error_code error;
        if (!fs::is_directory(folder, error))
            return fail(folder.string() + ": expected a folder with the frames of sensor '" + sensor.name +
                        "'");
        const Result<FrameStamps> stamps = read_timestamps(folder / "timestamps.csv");
        if (!stamps) return tl::unexpected(stamps.error());
        const auto frames = static_cast<int64_t>(stamps->timestamp_us.size());
        if (frames == 0) return fail((folder / "timestamps.csv").string() + ": expected at least one frame");
        const Result<int64_t> images = count_images(folder, report_.warnings);
        if (!images) return tl::unexpected(images.error());
        for (int64_t frame = 0; frame < frames; ++frame)
            if (!fs::exists(folder / frame_file_name(frame), error))
                return fail((folder / frame_file_name(frame)).string() + ": expected the image of frame " +
                            std::to_string(frame) + ", which timestamps.csv lists");
        if (*images != frames)
            return fail((folder / "timestamps.csv").string() + ": expected a line for each of " +
                        std::to_string(*images) + " images, found " + std::to_string(frames));
        for (int64_t frame = 0; frame < frames; ++frame)
            if (auto done = copy_frame(index, frame, *stamps); !done) return done;
        report_.frames.push_back(frames);
        return {};
    }

    Result<void> copy_frame(size_t index, int64_t frame, const FrameStamps& stamps) {
        const CalibratedSensor& sensor = rig_.sensors[index];
        const ImageSize size = {sensor.camera.width, sensor.camera.height};
        const fs::path file = folder_ / sensor.name / frame_file_name(frame);
        const int64_t stamp = stamps.timestamp_us[static_cast<size_t>(frame)];
        std::optional<int64_t> host;
        if (!stamps.host_us.empty()) host = stamps.host_us[static_cast<size_t>(frame)];
        const auto append = [&](const auto& image) { return writer_.append(index, stamp, image, host); };
        if (sensor.kind == SensorKind::video) return read_video_png(file, size).and_then(append);
        if (sensor.kind == SensorKind::infrared) return read_infrared_png(file, size).and_then(append);
        return read_depth_png(file, size).and_then(append);
    }

    const fs::path& folder_;
    const SensorRig& rig_;
    SessionWriter& writer_;
    ImportReport& report_;
};

}  // namespace

Result<ImportReport> import_frames(const fs::path& folder, const fs::path& out, SessionOrigin origin) {
    std::error_code error;
    if (!fs::is_directory(folder, error)) return fail(folder.string() + ": expected a frames folder");
    const Result<CalibrationFile> calibration = read_calibration(folder / "calibration.toml");
    if (!calibration) return tl::unexpected(calibration.error());
    ImportReport report;
    report.warnings = calibration->warnings;
    if (origin.name.empty()) origin.name = fs::canonical(folder, error).filename().string();
    Result<SessionWriter> writer = SessionWriter::create(out, calibration->rig, origin);
    if (!writer) return tl::unexpected(writer.error());
    Result<void> done = FramesImport(folder, calibration->rig, *writer, report).run();
    if (done) done = writer->finish();
    if (done) return report;
    // An import can be repeated; nothing is worth mending.
    fs::remove_all(writer->working_folder(), error);
    return tl::unexpected(done.error());
}

}  // namespace deixis
