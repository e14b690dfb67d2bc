// Writes a session folder: streams, background, part, truth, settings. Images in; a whole session or none
// out.
#include "appliance/sessions/session_writer.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <vector>

#include "appliance/calibration/calibration_file.h"
#include "appliance/calibration/toml_section.h"
#include "appliance/calibration/whole_file.h"
#include "appliance/sessions/frame_stamps.h"
#include "appliance/sessions/oni_writer.h"
#include "appliance/sessions/session.h"
#include "appliance/sessions/session_file.h"
#include "appliance/sessions/session_seal.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;

/// "a/b/" and "a/b" are the same folder.
fs::path without_slash(const fs::path& path) {
    fs::path plain = path.lexically_normal();
    return plain.has_filename() ? plain : plain.parent_path();
}

/// A text file that is written line by line; every line is with the kernel when `add` returns.
class LineFile {
  public:
    Result<void> add(const fs::path& path, std::string_view line) {
        if (!out_.is_open()) out_.open(path, std::ios::binary | std::ios::app);
        out_ << line << '\n' << std::flush;
        if (!out_) return fail(path.string() + ": cannot be written: " + std::strerror(errno));
        return {};
    }

  private:
    std::ofstream out_;
};

/// One sensor's stream while it is written.
struct OpenStream {
    std::optional<OniWriter> recording;  ///< absent for video
    int64_t frames = 0;
    int64_t first_us = 0;
    int64_t last_us = 0;
    bool with_host = false;
    LineFile stamps;  ///< timestamps.csv of video; the host's times beside a recording
};

Result<void> copy_whole(const fs::path& from, const fs::path& to) {
    std::error_code error;
    if (fs::copy_file(from, to, fs::copy_options::overwrite_existing, error)) return {};
    return fail(from.string() + ": cannot be copied to " + to.string() + ": " + error.message());
}

}  // namespace

struct SessionWriter::Impl {
    fs::path folder;
    fs::path working;
    SensorRig rig;
    SessionOrigin origin;
    std::vector<OpenStream> streams;
    LineFile truth;
    bool finished = false;

    std::string name_of_stream(size_t sensor) const { return rig.sensors[sensor].name; }

    fs::path stream_file(size_t sensor) const {
        const bool video = rig.sensors[sensor].kind == SensorKind::video;
        return video ? name_of_stream(sensor) : name_of_stream(sensor) + ".oni";
    }

    /// timestamps.csv of a video; beside a recording the file of the host's times.
    fs::path stamps_file(size_t sensor) const {
        const bool video = rig.sensors[sensor].kind == SensorKind::video;
        return video ? working / name_of_stream(sensor) / "timestamps.csv"
                     : working / (name_of_stream(sensor) + ".csv");
    }

    Session manifest() const {
        Session session;
        session.name = origin.name;
        session.created = origin.created;
        for (size_t i = 0; i < streams.size(); ++i) {
            SessionStream stream;
            stream.sensor = rig.sensors[i].name;
            stream.file = stream_file(i);
            // A recording counts from its first frame, as OpenNI2's own do; a video's stamps stand as they
            // came.
            stream.start_us = streams[i].recording ? streams[i].first_us : 0;
            stream.frames = streams[i].frames;
            if (streams[i].with_host && streams[i].recording) stream.host_times = stream.sensor + ".csv";
            session.streams.push_back(stream);
        }
        return session;
    }

    /// What the mender needs to know should this process die.
    Result<void> note_progress() const {
        return write_whole_file(working / "recording.toml",
                                session_text(manifest(), origin.tools, recording_format));
    }

    Result<void> open_streams() {
        streams.resize(rig.sensors.size());
        for (size_t i = 0; i < streams.size(); ++i) {
            const CalibratedSensor& sensor = rig.sensors[i];
            if (sensor.kind == SensorKind::video) {
                std::error_code error;
                if (!fs::create_directory(working / stream_file(i), error))
                    return fail((working / stream_file(i)).string() +
                                ": cannot be created: " + error.message());
                // The mender needs one from the start; the first frame may bring another header.
                if (auto done = write_whole_file(stamps_file(i), timestamps_header(false)); !done)
                    return done;
                continue;
            }
            Result<OniWriter> recording = OniWriter::create(
                working / stream_file(i), oni_format_of(sensor.camera, sensor.kind == SensorKind::infrared));
            if (!recording) return tl::unexpected(recording.error());
            streams[i].recording.emplace(std::move(*recording));
        }
        return {};
    }

    /// Everything that does not depend on the pixels.
    Result<void> check_frame(size_t sensor, int64_t timestamp_us, bool video, bool with_host) const {
        if (finished) return fail(folder.string() + ": is finished; nothing can be appended");
        if (sensor >= streams.size())
            return fail(folder.string() + ": expected a sensor below " + std::to_string(streams.size()) +
                        ", found " + std::to_string(sensor));
        const OpenStream& stream = streams[sensor];
        const std::string place =
            (working / stream_file(sensor)).string() + ": frame " + std::to_string(stream.frames);
        if (video == stream.recording.has_value())
            return fail(place + (video ? ": expected a 16 bit image" : ": expected an 8 bit image"));
        if (timestamp_us > stamp_limit_us || timestamp_us < -stamp_limit_us)
            return fail(place + ": expected a timestamp within 2^61 microseconds, found " +
                        std::to_string(timestamp_us));
        if (stream.frames > 0 && timestamp_us <= stream.last_us)
            return fail(place + ": expected a timestamp above " + std::to_string(stream.last_us) +
                        ", found " + std::to_string(timestamp_us));
        if (stream.frames > 0 && with_host != stream.with_host)
            return fail(place + (with_host ? ": expected no host_us, as frame 0 has none"
                                           : ": expected a host_us, as frame 0 has one"));
        return {};
    }

    /// The first frame decides whether the file has a column for the host's times.
    Result<void> add_stamps(size_t sensor, int64_t frame, int64_t timestamp_us,
                            std::optional<int64_t> host_us) {
        OpenStream& stream = streams[sensor];
        if (frame == 0 && host_us) {
            stream.with_host = true;
            if (auto done = write_whole_file(stamps_file(sensor), timestamps_header(true)); !done)
                return done;
        }
        std::string line = std::to_string(frame) + "," + std::to_string(timestamp_us);
        if (host_us) line.append(",").append(std::to_string(*host_us));
        return stream.stamps.add(stamps_file(sensor), line);
    }

    void count_frame(OpenStream& stream, int64_t timestamp_us) const {
        if (stream.frames == 0) stream.first_us = timestamp_us;
        stream.last_us = timestamp_us;
        ++stream.frames;
    }

    /// The path of a side file, unless the session has it already.
    Result<fs::path> side_file(const std::string& name) const {
        if (finished) return fail(folder.string() + ": is finished; nothing can be added");
        return working / name;
    }
};

SessionWriter::SessionWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SessionWriter::SessionWriter(SessionWriter&&) noexcept = default;
SessionWriter& SessionWriter::operator=(SessionWriter&&) noexcept = default;
SessionWriter::~SessionWriter() = default;

Result<SessionWriter> SessionWriter::create(const fs::path& folder, const SensorRig& rig,
                                            const SessionOrigin& origin) {
    auto impl = std::make_unique<Impl>();
    impl->folder = without_slash(folder);
    impl->working = impl->folder.string() + ".recording";
    impl->rig = rig;
    impl->origin = origin;
    if (!is_utc_time(origin.created))
        return fail(folder.string() +
                    ": key 'created': expected a time like \"2026-11-22T10:00:00Z\", found \"" +
                    origin.created + "\"");
    std::error_code error;
    if (fs::exists(impl->folder, error)) return fail(impl->folder.string() + ": exists already");
    if (fs::exists(impl->working, error))
        return fail(impl->working.string() + ": is an interrupted recording; mend or remove it first");
    if (impl->folder.has_parent_path()) fs::create_directories(impl->folder.parent_path(), error);
    if (error || !fs::create_directory(impl->working, error))
        return fail(impl->working.string() + ": cannot be created: " + error.message());
    Result<void> done = write_calibration(rig, impl->working / "calibration.toml");
    if (done) done = impl->open_streams();
    if (done) done = impl->note_progress();
    if (!done) {
        fs::remove_all(impl->working, error);
        return tl::unexpected(done.error());
    }
    return SessionWriter(std::move(impl));
}

Result<void> SessionWriter::append(size_t sensor, int64_t timestamp_us, const DepthImage& image,
                                   std::optional<int64_t> host_us) {
    if (auto checked = impl_->check_frame(sensor, timestamp_us, false, host_us.has_value()); !checked)
        return checked;
    OpenStream& stream = impl_->streams[sensor];
    const bool first = stream.frames == 0;
    const int64_t start_us = first ? timestamp_us : stream.first_us;
    if (auto done = stream.recording->append(timestamp_us - start_us, image); !done) return done;
    impl_->count_frame(stream, timestamp_us);
    if (host_us)
        if (auto done = impl_->add_stamps(sensor, stream.frames - 1, timestamp_us, host_us); !done)
            return done;
    return first ? impl_->note_progress() : Result<void>{};
}

Result<void> SessionWriter::append(size_t sensor, int64_t timestamp_us, const VideoImage& image,
                                   std::optional<int64_t> host_us) {
    if (auto checked = impl_->check_frame(sensor, timestamp_us, true, host_us.has_value()); !checked)
        return checked;
    OpenStream& stream = impl_->streams[sensor];
    const CameraModel& camera = impl_->rig.sensors[sensor].camera;
    const fs::path file = impl_->working / impl_->stream_file(sensor) / frame_file_name(stream.frames);
    if (image.width != camera.width || image.height != camera.height ||
        (image.channels != 1 && image.channels != 3) ||
        image.bytes.size() !=
            static_cast<size_t>(image.width) * static_cast<size_t>(image.height * image.channels))
        return fail(file.string() + ": expected " + std::to_string(camera.width) + " x " +
                    std::to_string(camera.height) + " pixels of one or three channels, found " +
                    std::to_string(image.width) + " x " + std::to_string(image.height) + " of " +
                    std::to_string(image.channels));
    if (auto done = write_video_png(image, file); !done) return done;
    if (auto done = impl_->add_stamps(sensor, stream.frames, timestamp_us, host_us); !done) return done;
    impl_->count_frame(stream, timestamp_us);
    return {};
}

Result<void> SessionWriter::set_background(size_t sensor, const DepthImage& image) {
    if (sensor >= impl_->streams.size() || impl_->rig.sensors[sensor].kind != SensorKind::depth)
        return fail(impl_->folder.string() + ": expected a depth sensor for the background");
    const CameraModel& camera = impl_->rig.sensors[sensor].camera;
    const Result<fs::path> folder = impl_->side_file("background");
    if (!folder) return tl::unexpected(folder.error());
    const fs::path file = *folder / (impl_->name_of_stream(sensor) + ".png");
    if (image.width != camera.width || image.height != camera.height)
        return fail(file.string() + ": expected " + std::to_string(camera.width) + " x " +
                    std::to_string(camera.height) + " pixels, found " + std::to_string(image.width) + " x " +
                    std::to_string(image.height));
    if (std::find(image.millimetres.begin(), image.millimetres.end(), uint16_t{65535}) !=
        image.millimetres.end())
        return fail(file.string() + ": expected 0 to 65534 mm, found 65535");
    std::error_code error;
    fs::create_directory(*folder, error);
    if (error) return fail(folder->string() + ": cannot be created: " + error.message());
    return write_depth_png(image, file);
}

Result<void> SessionWriter::copy_part(const fs::path& part_toml) {
    const std::string name = part_toml.string();
    const Result<fs::path> target = impl_->side_file("part.toml");
    if (!target) return tl::unexpected(target.error());
    const Result<std::string> text = read_whole_file(part_toml, size_t{1} << 20);
    if (!text) return tl::unexpected(text.error());
    Result<toml::table> part = parse_toml(*text, name);
    if (!part) return tl::unexpected(part.error());
    TomlComplaints complaints{name, {}, {}};
    const std::string given = TomlSection(*part, "", complaints).text("model", "the name of the model file");
    if (complaints.first) return tl::unexpected(*complaints.first);
    const fs::path model = part_toml.parent_path() / given;
    const std::string plain = fs::path(given).filename().string();
    std::error_code error;
    if (plain.empty() || !fs::is_regular_file(model, error))
        return fail(name + ": key 'model': expected a model file, found nothing at " +
                    toml_quoted(model.string()));
    static const std::set<std::string> taken = {"session.toml",  "settings.toml", "calibration.toml",
                                                "part.toml",     "truth.jsonl",   "expected.toml",
                                                "recording.toml"};
    if (taken.contains(plain) || fs::exists(impl_->working / plain, error))
        return fail(name + ": key 'model': expected another file name than " + plain +
                    ", which the session uses itself");
    if (auto done = copy_whole(model, impl_->working / plain); !done) return done;
    if (given == plain) return write_whole_file(*target, *text);
    part->insert_or_assign("model", plain);
    std::ostringstream moved;
    moved << toml::default_formatter(*part) << '\n';
    return write_whole_file(*target, moved.str());
}

Result<void> SessionWriter::add_truth_line(std::string_view json_object) {
    const Result<fs::path> target = impl_->side_file("truth.jsonl");
    if (!target) return tl::unexpected(target.error());
    if (json_object.size() < 2 || json_object.front() != '{' || json_object.back() != '}' ||
        json_object.find('\n') != std::string_view::npos)
        return fail(target->string() + ": expected one JSON object on one line");
    return impl_->truth.add(*target, json_object);
}

Result<void> SessionWriter::copy_truth(const fs::path& file) {
    return impl_->side_file("truth.jsonl").and_then([&](const fs::path& to) { return copy_whole(file, to); });
}

Result<void> SessionWriter::copy_expected(const fs::path& file) {
    return impl_->side_file("expected.toml").and_then([&](const fs::path& to) {
        return copy_whole(file, to);
    });
}

Result<void> SessionWriter::copy_settings(const fs::path& file) {
    return impl_->side_file("settings.toml").and_then([&](const fs::path& to) {
        return copy_whole(file, to);
    });
}

Result<void> SessionWriter::copy_calibration(const fs::path& file) {
    return impl_->side_file("calibration.toml").and_then([&](const fs::path& to) {
        return copy_whole(file, to);
    });
}

Result<void> SessionWriter::set_expected(std::string_view toml) {
    return impl_->side_file("expected.toml").and_then([&](const fs::path& to) {
        return write_whole_file(to, toml);
    });
}

Result<void> SessionWriter::set_settings(std::string_view toml) {
    return impl_->side_file("settings.toml").and_then([&](const fs::path& to) {
        return write_whole_file(to, toml);
    });
}

Result<void> SessionWriter::finish() {
    if (impl_->finished) return fail(impl_->folder.string() + ": is finished already");
    for (OpenStream& stream : impl_->streams)
        if (stream.recording)
            if (auto done = stream.recording->finish(); !done) return done;
    Session session = impl_->manifest();
    if (auto done = seal_session(session, impl_->origin.tools, impl_->working, impl_->folder); !done)
        return done;
    impl_->finished = true;
    return {};
}

const fs::path& SessionWriter::working_folder() const {
    return impl_->working;
}

}  // namespace deixis
