// Writes an OpenNI2 recording (.oni) of one 16-bit stream, lossless; ends a torn one. Images in, file out.
#include "appliance/sessions/oni_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "appliance/sessions/growing_file.h"
#include "appliance/sessions/oni_frame_log.h"
#include "appliance/sessions/oni_frames.h"
#include "appliance/sessions/oni_head.h"
#include "appliance/sessions/oni_layout.h"

namespace deixis {
namespace {

using oni::Head;

Head open_head(const OniFormat& format, OniCodec codec) {
    Head head;
    head.format = format;
    if (head.format.fps == 0) head.format.fps = oni::assumed_fps;
    head.codec = codec;
    head.header_last_us = oni::open_end_u64;
    head.node_last_us = oni::open_end_u64;
    head.frames = oni::open_end_u32;
    return head;
}

}  // namespace

OniFormat oni_format_of(const CameraModel& camera, bool infrared) {
    const auto angle = [](double size, double centre, double focal) {
        return std::atan2(centre + 0.5, focal) + std::atan2(size - 0.5 - centre, focal);
    };
    OniFormat format;
    format.width = camera.width;
    format.height = camera.height;
    format.horizontal_fov = std::clamp(angle(camera.width, camera.cx, camera.fx), 0.0, 3.14);
    format.vertical_fov = std::clamp(angle(camera.height, camera.cy, camera.fy), 0.0, 3.14);
    format.infrared = infrared;
    return format;
}

struct OniWriter::Impl {
    std::filesystem::path path;
    OniFormat format;
    Head head;
    std::unique_ptr<GrowingFile> file;
    oni::FrameLog log;
    DepthEncoder encoder;
    std::vector<uint8_t> coded;
    bool finished = false;

    Result<void> start(GrowingFile& target, OniCodec codec, Head& target_head) const {
        target_head = open_head(format, codec);
        const std::vector<uint8_t> bytes = oni::compose_head(target_head);
        return target.append(bytes, {});
    }

    Result<void> append_coded(GrowingFile& target, oni::FrameLog& target_log, int64_t timestamp_us) const {
        const uint64_t at = target.end();
        if (auto done = target.append(oni::frame_head(target_log, timestamp_us, coded.size()), coded); !done)
            return done;
        target_log.add(timestamp_us, at);
        return {};
    }

    bool encode(OniCodec codec, const DepthImage& image) {
        return encoder.encode(codec, image.millimetres, coded) &&
               coded.size() + oni::new_data_bytes <= oni::largest_record;
    }

    /// Writes all frames so far once more, uncoded, and goes on with that file. The old one stays until the
    /// new is whole.
    Result<void> rewrite_uncoded() {
        auto fresh = std::make_unique<GrowingFile>(path.string() + ".uncoded");
        oni::FrameLog fresh_log;
        Head fresh_head;
        if (auto done = fresh->open(O_CREAT | O_TRUNC, 0); !done) return done;
        Result<void> done = start(*fresh, OniCodec::none, fresh_head);
        if (done) done = copy_frames_uncoded(*fresh, fresh_log);
        if (done) done = fresh->rename_to(path);
        if (!done) {
            ::unlink(fresh->path().c_str());
            return done;
        }
        file = std::move(fresh);
        log = std::move(fresh_log);
        head = fresh_head;
        return {};
    }

    Result<void> copy_frames_uncoded(GrowingFile& target, oni::FrameLog& target_log) {
        Result<OniBytes> bytes = OniBytes::open(path);
        if (!bytes) return tl::unexpected(bytes.error());
        const std::string name = path.string();
        oni::FrameReader frames(*bytes, name, head);
        while (frames.at() < file->end()) {
            const Result<bool> more = frames.next(true);
            if (!more) return tl::unexpected(more.error());
            encode(OniCodec::none, frames.image());
            if (auto done = append_coded(target, target_log, frames.timestamp_us()); !done) return done;
        }
        return {};
    }

    std::optional<Failure> refusal(int64_t timestamp_us, const DepthImage& image) const {
        const std::string name = path.string() + ": frame " + std::to_string(log.frames);
        if (finished) return Failure{path.string() + ": is finished; nothing can be appended"};
        if (image.width != format.width || image.height != format.height ||
            image.millimetres.size() !=
                static_cast<size_t>(format.width) * static_cast<size_t>(format.height))
            return Failure{name + ": expected " + std::to_string(format.width) + " x " +
                           std::to_string(format.height) + " pixels, found " + std::to_string(image.width) +
                           " x " + std::to_string(image.height)};
        if (timestamp_us < 0 || timestamp_us > oni::largest_stamp)
            return Failure{name + ": expected a timestamp from 0 to 2^62 microseconds, found " +
                           std::to_string(timestamp_us)};
        if (log.frames > 0 && timestamp_us < log.last_us)
            return Failure{name + ": expected a timestamp not before " + std::to_string(log.last_us) +
                           ", found " + std::to_string(timestamp_us)};
        if (log.frames >= int64_t{oni::open_end_u32} - 1)
            return Failure{name + ": expected fewer than 2^32 - 1 frames"};
        if (format.infrared) return std::nullopt;
        const auto& pixels = image.millimetres;
        const auto found = std::find(pixels.begin(), pixels.end(), uint16_t{65535});
        if (found == pixels.end()) return std::nullopt;
        const int64_t index = found - pixels.begin();
        return Failure{name + ": pixel (" + std::to_string(index % format.width) + ", " +
                       std::to_string(index / format.width) + "): expected 0 to 65534 mm, found 65535"};
    }
};

OniWriter::OniWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OniWriter::OniWriter(OniWriter&&) noexcept = default;
OniWriter& OniWriter::operator=(OniWriter&&) noexcept = default;
OniWriter::~OniWriter() = default;

Result<OniWriter> OniWriter::create(const std::filesystem::path& path, const OniFormat& format) {
    const bool size_fits =
        format.width > 0 && format.height > 0 && format.width <= 0xFFFF && format.height <= 0xFFFF &&
        uint64_t{2} * static_cast<uint64_t>(format.width) * static_cast<uint64_t>(format.height) <=
            oni::largest_image;
    if (!size_fits)
        return fail(path.string() + ": expected images of 1 to 2880000 pixels, found " +
                    std::to_string(format.width) + " x " + std::to_string(format.height));
    auto impl = std::make_unique<Impl>();
    impl->path = path;
    impl->format = format;
    impl->file = std::make_unique<GrowingFile>(path);
    if (auto done = impl->file->open(O_CREAT | O_TRUNC, 0); !done) return tl::unexpected(done.error());
    if (auto done = impl->start(*impl->file, format.infrared ? OniCodec::none : OniCodec::table, impl->head);
        !done)
        return tl::unexpected(done.error());
    return OniWriter(std::move(impl));
}

Result<void> OniWriter::append(int64_t timestamp_us, const DepthImage& image) {
    Impl& w = *impl_;
    if (auto refused = w.refusal(timestamp_us, image)) return tl::unexpected(*refused);
    if (!w.encode(w.head.codec, image)) {
        if (auto done = w.rewrite_uncoded(); !done) return done;
        w.encode(OniCodec::none, image);
    }
    return w.append_coded(*w.file, w.log, timestamp_us);
}

Result<void> OniWriter::finish() {
    Impl& w = *impl_;
    if (w.finished) return {};
    Head closed = w.head;
    if (w.format.fps == 0) closed.format.fps = oni::fps_of(w.log);
    if (auto done = oni::close_records(*w.file, w.log, closed); !done) return done;
    // First the records, then the heads that speak of them: a power cut in between leaves a file that can be
    // mended.
    if (auto done = w.file->sync(); !done) return done;
    if (auto done = w.file->patch(0, oni::compose_head(closed)); !done) return done;
    if (auto done = w.file->sync(); !done) return done;
    w.head = closed;
    w.finished = true;
    return {};
}

int64_t OniWriter::frames() const {
    return impl_->log.frames;
}
OniCodec OniWriter::codec() const {
    return impl_->head.codec;
}

}  // namespace deixis
