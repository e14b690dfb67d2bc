// A recorded session as a value: opened, checked, and its background and side files read.
#include "appliance/sessions/session.h"

#include <algorithm>
#include <fstream>
#include <memory>

#include "appliance/calibration/calibration_file.h"
#include "appliance/calibration/toml_section.h"
#include "appliance/calibration/whole_file.h"
#include "appliance/sessions/depth_png.h"
#include "appliance/sessions/frame_stamps.h"
#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/session_file.h"
#include "appliance/sessions/stream_checksum.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;

std::string stream_key(const Session& session, size_t index, const char* key) {
    return (session.folder / "session.toml").string() + ": key 'stream[" + std::to_string(index) + "]." +
           key + "'";
}

bool exists_as(const fs::path& path, fs::file_type type) {
    std::error_code error;
    return fs::status(path, error).type() == type;
}

/// The recording's own head must agree with session.toml and calibration.toml.
Result<void> check_recording(const Session& session, size_t index, const CalibratedSensor& sensor) {
    const SessionStream& stream = session.streams[index];
    if (!exists_as(stream.file, fs::file_type::regular))
        return fail(stream_key(session, index, "file") + ": expected a recording at " + stream.file.string());
    const Result<OniSummary> head = read_oni_head(stream.file);
    if (!head) return tl::unexpected(head.error());
    if (head->width != sensor.camera.width || head->height != sensor.camera.height)
        return fail(stream.file.string() + ": expected " + std::to_string(sensor.camera.width) + " x " +
                    std::to_string(sensor.camera.height) + " pixels as in calibration.toml, found " +
                    std::to_string(head->width) + " x " + std::to_string(head->height));
    if (head->frames != stream.frames)
        return fail(stream_key(session, index, "frames") + ": expected " + std::to_string(head->frames) +
                    " as in " + stream.file.filename().string() + ", found " + std::to_string(stream.frames));
    if (head->infrared != (sensor.kind == SensorKind::infrared))
        return fail(stream.file.string() + ": expected " +
                    (sensor.kind == SensorKind::infrared ? "an infrared" : "a depth") +
                    " stream as in calibration.toml, found the other kind");
    return {};
}

Result<void> check_stream(const Session& session, size_t index, const CalibratedSensor& sensor, bool verify) {
    const SessionStream& stream = session.streams[index];
    if (sensor.kind == SensorKind::video) {
        if (!exists_as(stream.file, fs::file_type::directory))
            return fail(stream_key(session, index, "file") + ": expected a folder of PNG files at " +
                        stream.file.string());
        if (const Result<VideoStream> video = open_video_stream(stream); !video)
            return tl::unexpected(video.error());
    } else if (auto checked = check_recording(session, index, sensor); !checked) {
        return checked;
    }
    if (stream.host_times && !exists_as(*stream.host_times, fs::file_type::regular))
        return fail(stream_key(session, index, "host_times") + ": expected a file at " +
                    stream.host_times->string());
    if (!verify) return {};
    const Result<std::string> checksum = stream_checksum(stream.file);
    if (!checksum) return tl::unexpected(checksum.error());
    if (*checksum != stream.checksum)
        return fail(stream_key(session, index, "checksum") + ": expected " + stream.checksum + ", found " +
                    *checksum + "; " + stream.file.filename().string() + " is not what was recorded");
    return {};
}

/// Streams in the order of the rig, one for each sensor, files as paths.
Result<void> order_streams(Session& session) {
    for (size_t i = 0; i < session.streams.size(); ++i) {
        const auto known = [&](const CalibratedSensor& s) { return s.name == session.streams[i].sensor; };
        if (std::none_of(session.rig.sensors.begin(), session.rig.sensors.end(), known))
            return fail(stream_key(session, i, "sensor") + ": expected a sensor of calibration.toml, found " +
                        toml_quoted(session.streams[i].sensor));
    }
    std::vector<SessionStream> ordered;
    for (const CalibratedSensor& sensor : session.rig.sensors) {
        const auto found = std::find_if(session.streams.begin(), session.streams.end(),
                                        [&](const SessionStream& s) { return s.sensor == sensor.name; });
        if (found == session.streams.end())
            return fail((session.folder / "session.toml").string() +
                        ": key 'stream': expected a stream of sensor '" + sensor.name +
                        "', which calibration.toml names");
        ordered.push_back(*found);
    }
    for (SessionStream& stream : ordered) {
        stream.file = session.folder / stream.file;
        if (stream.host_times) stream.host_times = session.folder / *stream.host_times;
    }
    session.streams = std::move(ordered);
    return {};
}

std::optional<fs::path> where_present(const fs::path& path) {
    return exists_as(path, fs::file_type::regular) ? std::optional(path) : std::nullopt;
}

}  // namespace

Result<Session> open_session(const fs::path& given, bool verify) {
    std::error_code error;
    const fs::path folder = fs::absolute(given, error).lexically_normal();
    if (error || !exists_as(folder, fs::file_type::directory))
        return fail(given.string() + ": expected a session folder");
    if (exists_as(folder / "recording.toml", fs::file_type::regular) &&
        !exists_as(folder / "session.toml", fs::file_type::regular))
        return fail(folder.string() +
                    ": expected a finished session; this recording was interrupted and can be mended");
    const fs::path manifest = folder / "session.toml";
    const Result<std::string> text = read_whole_file(manifest, largest_toml);
    if (!text) return tl::unexpected(text.error());
    Result<Session> parsed = parse_session(*text, manifest.string());
    if (!parsed) return parsed;
    Session session = std::move(*parsed);
    session.folder = folder;
    Result<CalibrationFile> calibration = read_calibration(folder / "calibration.toml");
    if (!calibration) return tl::unexpected(calibration.error());
    session.rig = std::move(calibration->rig);
    session.warnings.insert(session.warnings.end(), calibration->warnings.begin(),
                            calibration->warnings.end());
    if (auto ordered = order_streams(session); !ordered) return tl::unexpected(ordered.error());
    for (size_t i = 0; i < session.streams.size(); ++i)
        if (auto checked = check_stream(session, i, session.rig.sensors[i], verify); !checked)
            return tl::unexpected(checked.error());
    session.settings = where_present(folder / "settings.toml");
    session.part = where_present(folder / "part.toml");
    session.truth = where_present(folder / "truth.jsonl");
    session.expected = where_present(folder / "expected.toml");
    return session;
}

Result<VideoStream> open_video_stream(const SessionStream& stream) {
    Result<FrameStamps> stamps = read_timestamps(stream.file / "timestamps.csv");
    if (!stamps) return tl::unexpected(stamps.error());
    if (static_cast<int64_t>(stamps->timestamp_us.size()) != stream.frames)
        return fail((stream.file / "timestamps.csv").string() + ": expected " +
                    std::to_string(stream.frames) + " frames as in session.toml, found " +
                    std::to_string(stamps->timestamp_us.size()));
    VideoStream video;
    video.timestamp_us = std::move(stamps->timestamp_us);
    for (int64_t frame = 0; frame < stream.frames; ++frame) {
        video.files.push_back(stream.file / frame_file_name(frame));
        if (!exists_as(video.files.back(), fs::file_type::regular))
            return fail(video.files.back().string() + ": expected the image of frame " +
                        std::to_string(frame));
    }
    return video;
}

Result<std::vector<int64_t>> read_host_times(const SessionStream& stream) {
    // A video's own stamps hold them.
    const bool in_video = !stream.host_times && exists_as(stream.file, fs::file_type::directory);
    if (!stream.host_times && !in_video) return std::vector<int64_t>{};
    const fs::path csv = in_video ? stream.file / "timestamps.csv" : *stream.host_times;
    Result<FrameStamps> stamps = read_timestamps(csv);
    if (!stamps) return tl::unexpected(stamps.error());
    if (in_video && stamps->host_us.empty()) return std::vector<int64_t>{};
    if (static_cast<int64_t>(stamps->host_us.size()) != stream.frames)
        return fail(csv.string() + ": expected a host_us for each of " + std::to_string(stream.frames) +
                    " frames, found " + std::to_string(stamps->host_us.size()));
    return std::move(stamps->host_us);
}

Result<std::vector<std::optional<DepthImage>>> read_background(const Session& session) {
    std::vector<std::optional<DepthImage>> images;
    for (const CalibratedSensor& sensor : session.rig.sensors) {
        if (sensor.kind != SensorKind::depth) continue;
        images.emplace_back();
        const fs::path path = session.folder / "background" / (sensor.name + ".png");
        std::error_code error;
        if (!fs::exists(path, error)) continue;
        Result<DepthImage> image = read_depth_png(path, {sensor.camera.width, sensor.camera.height});
        if (!image) return tl::unexpected(image.error());
        images.back() = std::move(*image);
    }
    return images;
}

}  // namespace deixis
