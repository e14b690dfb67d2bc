// The frame records of a recording, one after the other, checked and decoded; shared by walker and mender.
#include "appliance/sessions/oni_frames.h"

#include "appliance/sessions/oni_layout.h"

namespace deixis::oni {

FrameReader::FrameReader(OniBytes& bytes, const std::string& name, const Head& head)
    : bytes_(bytes), name_(name), head_(head), at_(head.frames_at) {}

Result<bool> FrameReader::next(bool decode) {
    const auto refuse = [&](uint64_t offset, const std::string& expected) {
        return tl::unexpected(fault_at(name_, offset, expected));
    };
    const auto type = bytes_.window(at_, 8);
    if (type && get<uint32_t>(type->data()) == record_magic && get<uint32_t>(type->data() + 4) == end_record)
        return false;  // of node 0, and so not for read_record_head below
    const Result<RecordHead> record = read_record_head(bytes_, name_, at_, only_node);
    if (!record) return tl::unexpected(record.error());
    if (record->type != new_data) return false;
    if (record->fields_bytes != new_data_bytes) return refuse(at_ + 12, "40 bytes before a frame's pixels");
    const auto window = bytes_.window(at_, size_t{record->fields_bytes} + record->payload_bytes);
    if (!window) return refuse(at_, "a readable file");
    const uint64_t stamp = get<uint64_t>(window->data() + record_head_bytes);
    const uint32_t frame_id = get<uint32_t>(window->data() + record_head_bytes + 8);
    if (stamp > static_cast<uint64_t>(largest_stamp))
        return refuse(at_ + record_head_bytes, "a timestamp below 2^62 microseconds");
    if (stamp > head_.header_last_us || stamp > head_.node_last_us)
        return refuse(at_ + record_head_bytes, "a timestamp not above the last one that the heads give");
    if (frames_ > 0 && static_cast<int64_t>(stamp) < timestamp_us_)
        return refuse(at_ + record_head_bytes, "a timestamp not before that of the frame before");
    if (frame_id != frames_ + 1)
        return refuse(at_ + record_head_bytes + 8, "frame id " + std::to_string(frames_ + 1));
    if (frame_id > head_.frames)
        return refuse(at_ + record_head_bytes + 8,
                      "no frame after the " + std::to_string(head_.frames) + " that node added counts");
    const uint64_t image_bytes =
        uint64_t{2} * static_cast<uint64_t>(head_.format.width) * static_cast<uint64_t>(head_.format.height);
    if (head_.codec == OniCodec::none && record->payload_bytes != image_bytes)
        return refuse(at_ + 16, std::to_string(image_bytes) + " bytes of pixels");
    if (record->payload_bytes == 0) return refuse(at_ + 16, "pixels");
    if (decode) {
        image_.resize(head_.format.width, head_.format.height);
        const auto fault = decode_depth(head_.codec, window->subspan(new_data_bytes), image_.millimetres);
        if (fault)
            return refuse(
                at_ + new_data_bytes + fault->offset,
                std::string(fault->expected) + " in the pixels of frame " + std::to_string(frame_id));
    }
    frame_at_ = at_;
    at_ += window->size();
    ++frames_;
    timestamp_us_ = static_cast<int64_t>(stamp);
    return true;
}

}  // namespace deixis::oni
