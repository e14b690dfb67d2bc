// The strict look at an .oni recording before OpenNI2 may open it, and our own reader. File or bytes in,
// frames out.
#include "appliance/sessions/oni_walker.h"

#include <algorithm>
#include <vector>

#include "appliance/sessions/oni_bytes.h"
#include "appliance/sessions/oni_frames.h"
#include "appliance/sessions/oni_head.h"
#include "appliance/sessions/oni_layout.h"

namespace deixis {
namespace {

using oni::fault_at;
using oni::Head;
using oni::RecordHead;

/// One frame as the seek table should list it.
struct SeekEntry {
    int64_t timestamp_us;
    uint64_t at;
};

OniSummary summary_of(const Head& head) {
    OniSummary summary;
    summary.width = head.format.width;
    summary.height = head.format.height;
    summary.fps = head.format.fps;
    summary.infrared = head.format.infrared;
    summary.codec = head.codec;
    summary.horizontal_fov = head.format.horizontal_fov;
    summary.vertical_fov = head.format.vertical_fov;
    summary.frames = head.frames;
    return summary;
}

class RecordingWalk {
  public:
    RecordingWalk(OniBytes& bytes, const std::string& name) : bytes_(bytes), name_(name) {}

    Result<OniSummary> walk(bool decode, const OniFrameCallback& each) {
        const Result<Head> head = oni::read_head(bytes_, name_);
        if (!head) return tl::unexpected(head.error());
        if (head->open_ended())
            return tl::unexpected(
                fault_at(name_, oni::header_last_us_at,
                         "a finished recording; this one was interrupted and can be mended"));
        const bool with_table = head->seek_table_at != 0;
        if (with_table && head->frames > oni::longest_seek_table)
            return tl::unexpected(fault_at(name_, oni::file_header_bytes,
                                           "no seek table in a recording of more than 288003 frames"));
        OniSummary summary = summary_of(*head);
        oni::FrameReader frames(bytes_, name_, *head);
        for (;;) {
            const Result<bool> more = frames.next(decode);
            if (!more) return tl::unexpected(more.error());
            if (!*more) break;
            if (frames.frames() == 1) summary.first_us = frames.timestamp_us();
            summary.last_us = frames.timestamp_us();
            if (with_table) entries_.push_back({frames.timestamp_us(), frames.frame_at()});
            if (each && !each(frames.frames() - 1, frames.timestamp_us(), frames.image())) return summary;
        }
        if (frames.frames() != head->frames)
            return tl::unexpected(fault_at(
                name_, frames.at(),
                "frame " + std::to_string(frames.frames() + 1) + " of " + std::to_string(head->frames)));
        at_ = frames.at();
        if (auto fault = walk_tail(*head)) return tl::unexpected(*fault);
        summary.data_bytes = at_;
        return summary;
    }

  private:
    using Fault = std::optional<Failure>;

    /// What follows the frames: node removed (may be missing), seek table (if the head says so), end, zeros.
    Fault walk_tail(const Head& head) {
        bool removed = false;
        bool table = false;
        for (;;) {
            const auto type_bytes = bytes_.window(at_ + 4, 4);
            if (!type_bytes) return fault_at(name_, bytes_.size(), "the end record (0x0B)");
            const uint32_t type = oni::get<uint32_t>(type_bytes->data());
            const uint32_t node = type == oni::end_record ? 0 : oni::only_node;
            const Result<RecordHead> record = oni::read_record_head(bytes_, name_, at_, node);
            if (!record) return record.error();
            if (record->fields_bytes != oni::record_head_bytes)
                return fault_at(name_, at_ + 12, "28 bytes before the payload of a record after the frames");
            if (type == oni::seek_table && !table) {
                if (auto fault = judge_seek_table(head, *record)) return fault;
                table = true;
            } else if (record->payload_bytes != 0) {
                return fault_at(name_, at_ + 16, "no payload");
            } else if (type == oni::node_removed && !removed && !table) {
                removed = true;
            } else if (type == oni::end_record) {
                break;
            } else {
                return fault_at(name_, at_ + 4,
                                "node removed, seek table and end after the frames, in this order");
            }
            at_ += uint64_t{record->fields_bytes} + record->payload_bytes;
        }
        if (head.seek_table_at != 0 && !table)
            return fault_at(
                name_, at_,
                "the seek table that node added places at byte " + std::to_string(head.seek_table_at));
        at_ += oni::record_head_bytes;
        if (const auto more = bytes_.first_nonzero(at_))
            return fault_at(name_, *more, "nothing, or zeros, after the end record");
        return std::nullopt;
    }

    Fault judge_seek_table(const Head& head, const RecordHead& record) {
        if (head.seek_table_at != at_)
            return fault_at(
                name_, at_,
                "no seek table here (node added says byte " + std::to_string(head.seek_table_at) + ")");
        if (record.payload_bytes != (entries_.size() + 1) * oni::seek_entry_bytes)
            return fault_at(name_, at_ + 16,
                            std::to_string(entries_.size() + 1) + " entries in the seek table");
        const uint64_t table_at = at_ + oni::record_head_bytes;
        for (size_t i = 0; i <= entries_.size(); ++i) {
            const uint64_t entry_at = table_at + i * oni::seek_entry_bytes;
            const auto entry = bytes_.window(entry_at, oni::seek_entry_bytes);
            if (!entry) return fault_at(name_, entry_at, "a readable file");
            const uint64_t stamp = i == 0 ? 0 : static_cast<uint64_t>(entries_[i - 1].timestamp_us);
            const uint64_t position = i == 0 ? 0 : entries_[i - 1].at;
            if (oni::get<uint64_t>(entry->data()) != stamp ||
                oni::get<uint64_t>(entry->data() + 12) != position)
                return fault_at(name_, entry_at,
                                "stamp and place of frame " + std::to_string(i) + " in the seek table");
            if (oni::get<uint32_t>(entry->data() + 8) != 0)
                return fault_at(name_, entry_at + 8, "configuration 0 in the seek table");
        }
        return std::nullopt;
    }

    OniBytes& bytes_;
    const std::string& name_;
    uint64_t at_ = 0;
    std::vector<SeekEntry> entries_;
};

}  // namespace

Result<OniSummary> walk_oni(const std::filesystem::path& path, OniPixels pixels) {
    Result<OniBytes> bytes = OniBytes::open(path);
    if (!bytes) return tl::unexpected(bytes.error());
    return RecordingWalk(*bytes, path.string()).walk(pixels == OniPixels::decoded, nullptr);
}

Result<OniSummary> walk_oni(std::span<const uint8_t> memory, const std::string& name, OniPixels pixels) {
    OniBytes bytes(memory);
    return RecordingWalk(bytes, name).walk(pixels == OniPixels::decoded, nullptr);
}

Result<OniSummary> read_oni_head(const std::filesystem::path& path) {
    Result<OniBytes> bytes = OniBytes::open(path);
    if (!bytes) return tl::unexpected(bytes.error());
    const Result<Head> head = oni::read_head(*bytes, path.string());
    if (!head) return tl::unexpected(head.error());
    if (head->open_ended())
        return tl::unexpected(fault_at(path.string(), oni::header_last_us_at,
                                       "a finished recording; this one was interrupted and can be mended"));
    OniSummary summary = summary_of(*head);
    summary.last_us = static_cast<int64_t>(head->node_last_us);
    return summary;
}

Result<OniSummary> read_oni(const std::filesystem::path& path, const OniFrameCallback& each) {
    Result<OniBytes> bytes = OniBytes::open(path);
    if (!bytes) return tl::unexpected(bytes.error());
    return RecordingWalk(*bytes, path.string()).walk(true, each);
}

Result<OniSummary> read_oni(std::span<const uint8_t> memory, const std::string& name,
                            const OniFrameCallback& each) {
    OniBytes bytes(memory);
    return RecordingWalk(bytes, name).walk(true, each);
}

}  // namespace deixis
