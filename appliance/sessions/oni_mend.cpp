// Makes a torn recording whole in place: keeps its whole frames, cuts the rest, writes the end and the heads.
#include <algorithm>
#include <string>

#include "appliance/sessions/growing_file.h"
#include "appliance/sessions/oni_frame_log.h"
#include "appliance/sessions/oni_frames.h"
#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/oni_writer.h"

namespace deixis {

Result<MendedRecording> mend_recording(const std::filesystem::path& path) {
    const std::string name = path.string();
    Result<OniBytes> bytes = OniBytes::open(path);
    if (!bytes) return tl::unexpected(bytes.error());
    MendedRecording mended;
    if (const Result<OniSummary> whole = walk_oni(path)) {
        mended.frames = whole->frames;
        mended.cut_bytes = bytes->size() - whole->data_bytes;
        mended.changed = mended.cut_bytes > 0;
        if (!mended.changed) return mended;
        GrowingFile file(path);
        if (auto done = file.open(0, bytes->size()); !done) return tl::unexpected(done.error());
        if (auto done = file.cut(whole->data_bytes); !done) return tl::unexpected(done.error());
        return mended;
    }
    const Result<oni::Head> found = oni::read_head(*bytes, name);
    if (!found) return tl::unexpected(found.error());
    oni::Head head = *found;
    oni::FrameReader frames(*bytes, name, head);
    oni::FrameLog log;
    for (;;) {
        // The first record that is not a whole frame ends the recording, be it torn or the old end.
        const Result<bool> more = frames.next(true);
        if (!more && frames.frames() == 0 && !head.open_ended()) return tl::unexpected(more.error());
        if (!more || !*more) break;
        log.add(frames.timestamp_us(), frames.frame_at());
    }
    GrowingFile file(path);
    if (auto done = file.open(0, bytes->size()); !done) return tl::unexpected(done.error());
    if (auto done = file.cut(frames.at()); !done) return tl::unexpected(done.error());
    if (auto done = oni::close_records(file, log, head); !done) return tl::unexpected(done.error());
    if (auto done = file.sync(); !done) return tl::unexpected(done.error());
    if (auto done = file.patch(0, oni::compose_file_header(head.header_last_us)); !done)
        return tl::unexpected(done.error());
    if (auto done = file.patch(oni::file_header_bytes, oni::compose_node_added(head)); !done)
        return tl::unexpected(done.error());
    if (auto done = file.sync(); !done) return tl::unexpected(done.error());
    mended.frames = log.frames;
    mended.cut_bytes = bytes->size() - frames.at();
    mended.changed = true;
    return mended;
}

}  // namespace deixis
