// Ends an interrupted recording: the `.recording` folder that a dead writer left becomes a session.
#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>

#include "appliance/calibration/whole_file.h"
#include "appliance/sessions/frame_stamps.h"
#include "appliance/sessions/oni_writer.h"
#include "appliance/sessions/session_file.h"
#include "appliance/sessions/session_seal.h"
#include "appliance/sessions/session_writer.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;

constexpr size_t largest_text = size_t{1} << 30;

/// A text file that lost its writer may end within a line.
Result<std::string> read_whole_lines(const fs::path& path) {
    Result<std::string> text = read_whole_file(path, largest_text);
    if (text) text->resize(text->rfind('\n') + 1);  // npos + 1 is 0: no whole line at all
    return text;
}

Result<void> cut_torn_line(const fs::path& path) {
    std::error_code error;
    if (!fs::exists(path, error)) return {};
    const Result<std::string> text = read_whole_lines(path);
    if (!text) return tl::unexpected(text.error());
    return write_whole_file(path, *text);
}

/// The stamps of the first `frames` frames, written back; false when the file has fewer.
bool mend_host_times(const fs::path& path, int64_t frames) {
    const Result<std::string> text = read_whole_lines(path);
    Result<FrameStamps> stamps = text ? parse_timestamps(*text, path.string()) : tl::unexpected(text.error());
    const auto count = static_cast<size_t>(frames);
    if (!stamps || stamps->timestamp_us.size() < count || stamps->host_us.size() < count) return false;
    stamps->timestamp_us.resize(count);
    stamps->host_us.resize(count);
    return write_whole_file(path, timestamps_text(*stamps)).has_value();
}

bool is_whole_png(const fs::path& path) {
    constexpr std::string_view last_chunk("\0\0\0\0IEND\xAE\x42\x60\x82", 12);
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in || in.tellg() < 45) return false;
    std::string end(last_chunk.size(), ' ');
    in.seekg(-static_cast<std::streamoff>(end.size()), std::ios::end);
    in.read(end.data(), static_cast<std::streamsize>(end.size()));
    return in && end == last_chunk;
}

/// Keeps the frames that have both a whole image and a stamp.
Result<void> mend_video(const fs::path& folder, int64_t& frames) {
    const fs::path csv = folder / "timestamps.csv";
    const Result<std::string> text = read_whole_lines(csv);
    if (!text) return tl::unexpected(text.error());
    Result<FrameStamps> stamps = parse_timestamps(*text, csv.string());
    if (!stamps) return tl::unexpected(stamps.error());
    frames = 0;
    while (frames < static_cast<int64_t>(stamps->timestamp_us.size()) &&
           is_whole_png(folder / frame_file_name(frames)))
        ++frames;
    std::error_code error;
    for (int64_t rest = frames; fs::remove(folder / frame_file_name(rest), error);) ++rest;
    stamps->timestamp_us.resize(static_cast<size_t>(frames));
    if (!stamps->host_us.empty()) stamps->host_us.resize(static_cast<size_t>(frames));
    return write_whole_file(csv, timestamps_text(*stamps));
}

}  // namespace

Result<fs::path> mend_session(const fs::path& recording_folder) {
    fs::path working = recording_folder.lexically_normal();
    if (!working.has_filename()) working = working.parent_path();  // "a.recording/" is "a.recording"
    const fs::path manifest = working / "recording.toml";
    if (working.extension() != ".recording")
        return fail(working.string() + ": expected a folder whose name ends in .recording");
    fs::path folder = working;
    folder.replace_extension();
    const Result<std::string> text = read_whole_file(manifest, size_t{1} << 20);
    if (!text) return tl::unexpected(text.error());
    Result<SessionText> parsed = parse_session_text(*text, manifest.string(), recording_format);
    if (!parsed) return tl::unexpected(parsed.error());
    for (SessionStream& stream : parsed->session.streams) {
        const fs::path file = working / stream.file;
        std::error_code error;
        if (fs::is_directory(file, error)) {
            if (auto mended = mend_video(file, stream.frames); !mended) return tl::unexpected(mended.error());
            continue;
        }
        const Result<MendedRecording> mended = mend_recording(file);
        if (!mended) return tl::unexpected(mended.error());
        stream.frames = mended->frames;
        if (stream.host_times && !mend_host_times(working / *stream.host_times, stream.frames))
            stream.host_times.reset();
    }
    if (auto done = cut_torn_line(working / "truth.jsonl"); !done) return tl::unexpected(done.error());
    if (auto done = seal_session(parsed->session, parsed->tools, working, folder); !done)
        return tl::unexpected(done.error());
    return folder;
}

}  // namespace deixis
