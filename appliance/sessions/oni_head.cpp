// The head of a recording, from the first byte to the first frame record: read strictly, or composed.
#include "appliance/sessions/oni_head.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "appliance/sessions/oni_layout.h"

namespace deixis::oni {
namespace {

/// A property that may stand in a head. `bytes` of its data; 0 = any number of modes of 12.
struct Property {
    std::string_view name;
    uint32_t type;
    uint32_t bytes;
};

constexpr std::array<Property, 14> properties = {{{"oniRequiredFrameSize", int_property, 8},
                                                  {"xnIsGenerating", int_property, 8},
                                                  {"xnDeviceMaxDepth", int_property, 8},
                                                  {"xnSupportedMapOutputModesCount", int_property, 8},
                                                  {"xnSupportedMapOutputModes", general_property, 0},
                                                  {"xnMapOutputMode", general_property, 12},
                                                  {"xnSupportedPixelFormats", general_property, 4},
                                                  {"xnPixelFormat", int_property, 8},
                                                  {"oniPixelFormat", int_property, 8},
                                                  {"xnFOV", general_property, 16},
                                                  {"Cropping", int_property, 8},
                                                  {"xnCropping", general_property, 12},
                                                  {"Mirror", int_property, 8},
                                                  {"xnMirror", int_property, 8}}};

constexpr uint32_t most_modes = 64;
constexpr size_t longest_property = 2048;

uint32_t four_characters(OniCodec codec) {
    return get<uint32_t>(reinterpret_cast<const uint8_t*>(name_of(codec)));
}

/// Where each property's data was found; the values are judged together at the end.
struct FoundProperty {
    uint64_t at = 0;
    std::vector<uint8_t> data;
};

class HeadReader {
  public:
    HeadReader(OniBytes& bytes, const std::string& name) : bytes_(bytes), name_(name) {}

    Result<Head> read() {
        if (auto fault = read_file_header()) return tl::unexpected(*fault);
        uint64_t at = file_header_bytes;
        if (auto fault = read_node_added(at)) return tl::unexpected(*fault);
        for (;;) {
            const Result<RecordHead> record = read_record_head(bytes_, name_, at, only_node);
            if (!record) return tl::unexpected(record.error());
            if (record->payload_bytes != 0)
                return tl::unexpected(fault_at(name_, at + 16, "no payload before the first frame"));
            if (record->type == state_ready) {
                if (record->fields_bytes != record_head_bytes)
                    return tl::unexpected(fault_at(name_, at + 12, "28 bytes of state ready"));
                break;
            }
            if (auto fault = read_property(at, *record)) return tl::unexpected(*fault);
            at += record->fields_bytes;
        }
        const uint64_t ready_at = at;
        if (auto fault = judge_properties(ready_at)) return tl::unexpected(*fault);
        if (auto fault = read_data_begin(ready_at + record_head_bytes)) return tl::unexpected(*fault);
        head_.frames_at = ready_at + record_head_bytes + data_begin_bytes;
        return head_;
    }

  private:
    using Fault = std::optional<Failure>;

    Fault complain(uint64_t at, const std::string& expected) const { return fault_at(name_, at, expected); }

    Fault read_file_header() {
        const auto header = bytes_.window(0, file_header_bytes);
        if (!header) return complain(bytes_.size(), "the 24 bytes of an OpenNI2 recording's header");
        for (size_t i = 0; i < file_identity.size(); ++i)
            if ((*header)[i] != file_identity[i])
                return complain(
                    i, i < 4 ? "\"NI10\", the mark of an OpenNI2 recording" : "format version 1.0.1.0");
        head_.header_last_us = get<uint64_t>(&(*header)[header_last_us_at]);
        if (head_.header_last_us > static_cast<uint64_t>(largest_stamp) &&
            head_.header_last_us != open_end_u64)
            return complain(header_last_us_at, "a largest timestamp below 2^62 microseconds");
        if (get<uint32_t>(&(*header)[20]) != only_node) return complain(20, "1 as the largest node id");
        return std::nullopt;
    }

    Fault read_node_added(uint64_t& at) {
        const Result<RecordHead> record = read_record_head(bytes_, name_, at, only_node);
        if (!record) return record.error();
        if (record->type != node_added) return complain(at + 4, "the node-added record (0x0D)");
        if (record->payload_bytes != 0) return complain(at + 16, "no payload in node added");
        const NodeKind* kind = nullptr;
        for (const NodeKind* k : {&depth_node, &infrared_node})
            if (record->fields_bytes == record_head_bytes + 4 + k->name.size() + 1 + 36) kind = k;
        if (kind == nullptr) return complain(at + 12, "74 bytes of node added (71 for infrared)");
        const auto found = bytes_.window(at, record->fields_bytes);
        if (!found) return complain(at, "a readable file");
        const std::span<const uint8_t> fields = *found;
        std::vector<uint8_t> text;
        put_text(text, kind->name);
        if (!std::equal(text.begin(), text.end(), fields.begin() + record_head_bytes))
            return complain(at + record_head_bytes, "the node's name, \"Depth\" or \"IR\"");
        const uint64_t numbers_at = at + record_head_bytes + text.size();
        const uint8_t* numbers = fields.data() + record_head_bytes + text.size();
        if (get<uint32_t>(numbers) != kind->type)
            return complain(numbers_at, "node type 2 (depth) or 5 (infrared)");
        head_.format.infrared = kind == &infrared_node;
        bool known = false;
        for (const OniCodec codec : {OniCodec::none, OniCodec::differences, OniCodec::table}) {
            if (get<uint32_t>(numbers + 4) != four_characters(codec)) continue;
            head_.codec = codec;
            known = true;
        }
        if (!known) return complain(numbers_at + 4, "codec NONE, 16zP or 16zT");
        head_.frames = get<uint32_t>(numbers + 8);
        head_.node_last_us = get<uint64_t>(numbers + 20);
        if (get<uint64_t>(numbers + 12) > head_.node_last_us)
            return complain(numbers_at + 12, "a first timestamp not above the last");
        if (head_.node_last_us != open_end_u64 && head_.node_last_us > head_.header_last_us)
            return complain(numbers_at + 20, "a last timestamp not above the header's");
        head_.seek_table_at = get<uint64_t>(numbers + 28);
        at += record->fields_bytes;
        return std::nullopt;
    }

    Fault read_property(uint64_t at, const RecordHead& record) {
        if (record.type != int_property && record.type != general_property)
            return complain(at + 4, "a property (0x03, 0x06) or state ready (0x09)");
        if (record.fields_bytes > longest_property)
            return complain(at + 12, "a property of at most 2048 bytes");
        const auto window = bytes_.window(at, record.fields_bytes);
        if (!window) return complain(at, "a readable file");
        const std::span<const uint8_t> fields = *window;
        if (fields.size() < record_head_bytes + 4) return complain(at + 12, "a property with a name");
        const uint8_t* text = fields.data() + record_head_bytes;
        const size_t left = fields.size() - record_head_bytes - 4;
        const size_t text_bytes = get<uint32_t>(text);
        if (text_bytes > left || left - text_bytes < 4 || text_bytes == 0)
            return complain(at + record_head_bytes, "the length of a property name inside its record");
        const std::string_view name(reinterpret_cast<const char*>(text + 4), text_bytes);
        size_t index = 0;
        while (index < properties.size() &&
               name != std::string_view(properties[index].name.data(), properties[index].name.size() + 1))
            ++index;
        if (index == properties.size()) return complain(at + record_head_bytes + 4, "a known property name");
        const Property& property = properties[index];
        if (property.type != record.type)
            return complain(at + 4, "the record type of property " + std::string(property.name));
        FoundProperty& found = found_[index];
        if (found.at != 0) return complain(at, "property " + std::string(property.name) + " only once");
        const size_t data_bytes = get<uint32_t>(text + 4 + text_bytes);
        const bool modes = property.bytes == 0;
        if (data_bytes != left - text_bytes - 4 || (!modes && data_bytes != property.bytes) ||
            (modes && (data_bytes == 0 || data_bytes % 12 != 0)))
            return complain(at + record_head_bytes + 4 + text_bytes,
                            "the exact data size of property " + std::string(property.name));
        found.at = at + record_head_bytes + 4 + text_bytes + 4;
        const uint8_t* data = text + 4 + text_bytes + 4;
        found.data.assign(data, data + data_bytes);
        return std::nullopt;
    }

    const FoundProperty* property(std::string_view name) const {
        for (size_t i = 0; i < properties.size(); ++i)
            if (properties[i].name == name) return found_[i].at == 0 ? nullptr : &found_[i];
        return nullptr;
    }

    /// Complains unless the int property is absent or in [low, high].
    Fault judge_int(std::string_view name, uint64_t low, uint64_t high) const {
        const FoundProperty* found = property(name);
        if (found == nullptr) return std::nullopt;
        const uint64_t value = get<uint64_t>(found->data.data());
        if (value >= low && value <= high) return std::nullopt;
        std::string range = std::to_string(low);
        if (high != low) range += " to " + std::to_string(high);
        return complain(found->at, range + " in property " + std::string(name));
    }

    Fault judge_mode(uint64_t ready_at) {
        const FoundProperty* mode = property("xnMapOutputMode");
        if (mode == nullptr) return complain(ready_at, "property xnMapOutputMode before it");
        const uint32_t width = get<uint32_t>(mode->data.data());
        const uint32_t height = get<uint32_t>(mode->data.data() + 4);
        const uint32_t fps = get<uint32_t>(mode->data.data() + 8);
        if (width == 0 || height == 0 || width > 0xFFFF || height > 0xFFFF ||
            uint64_t{2} * width * height > largest_image)
            return complain(mode->at, "an image of 1 to 2880000 pixels in property xnMapOutputMode");
        if (fps > 10'000)
            return complain(mode->at + 8, "at most 10000 frames a second in property xnMapOutputMode");
        head_.format.width = static_cast<int>(width);
        head_.format.height = static_cast<int>(height);
        head_.format.fps = static_cast<int>(fps);
        const FoundProperty* modes = property("xnSupportedMapOutputModes");
        if (modes == nullptr) return std::nullopt;
        const FoundProperty* count = property("xnSupportedMapOutputModesCount");
        if (count == nullptr || get<uint64_t>(count->data.data()) * 12 != modes->data.size())
            return complain(modes->at, "as many modes as property xnSupportedMapOutputModesCount says");
        return std::nullopt;
    }

    Fault judge_cropping(uint64_t ready_at) const {
        const FoundProperty* cropping = property("xnCropping");
        if (cropping == nullptr) return complain(ready_at, "property xnCropping before it");
        if (get<uint32_t>(cropping->data.data()) != 0) return complain(cropping->at, "cropping off");
        return std::nullopt;
    }

    Fault judge_fov() {
        const FoundProperty* fov = property("xnFOV");
        if (fov == nullptr) return std::nullopt;
        head_.format.horizontal_fov = get<double>(fov->data.data());
        head_.format.vertical_fov = get<double>(fov->data.data() + 8);
        for (const double angle : {head_.format.horizontal_fov, head_.format.vertical_fov})
            if (!(angle >= 0 && angle < 3.15))
                return complain(fov->at, "angles of 0 to 3.14 in property xnFOV");
        return std::nullopt;
    }

    Fault judge_properties(uint64_t ready_at) {
        if (auto fault = judge_mode(ready_at)) return fault;
        if (auto fault = judge_cropping(ready_at)) return fault;
        if (auto fault = judge_fov()) return fault;
        const bool depth = !head_.format.infrared;
        if (depth && property("xnDeviceMaxDepth") == nullptr)
            return complain(ready_at, "property xnDeviceMaxDepth before it");
        const uint64_t image_bytes = uint64_t{2} * static_cast<uint64_t>(head_.format.width) *
                                     static_cast<uint64_t>(head_.format.height);
        const uint64_t format = (depth ? depth_node : infrared_node).pixel_format;
        if (auto fault = judge_int("xnDeviceMaxDepth", 1, deepest_value)) return fault;
        if (auto fault = judge_int("oniRequiredFrameSize", image_bytes, image_bytes)) return fault;
        if (auto fault = judge_int("xnSupportedMapOutputModesCount", 1, most_modes)) return fault;
        if (auto fault = judge_int("oniPixelFormat", format, format)) return fault;
        if (auto fault = judge_int("xnPixelFormat", gray16, gray16)) return fault;
        for (const std::string_view flag : {"xnIsGenerating", "Cropping", "Mirror", "xnMirror"})
            if (auto fault = judge_int(flag, 0, 1)) return fault;
        return std::nullopt;
    }

    Fault read_data_begin(uint64_t at) {
        const Result<RecordHead> record = read_record_head(bytes_, name_, at, only_node);
        if (!record) return record.error();
        if (record->type != data_begin) return complain(at + 4, "the data-begin record (0x08)");
        if (record->fields_bytes != data_begin_bytes || record->payload_bytes != 0)
            return complain(at + 12, "40 bytes of data begin and no payload");
        const auto fields = bytes_.window(at, data_begin_bytes);
        if (!fields) return complain(at, "a readable file");
        for (size_t i = record_head_bytes; i < data_begin_bytes; ++i)
            if ((*fields)[i] != 0xFF) return complain(at + i, "all ones in data begin");
        return std::nullopt;
    }

    OniBytes& bytes_;
    const std::string& name_;
    Head head_;
    std::array<FoundProperty, properties.size()> found_;
};

void put_property_head(std::vector<uint8_t>& out, std::string_view name, uint32_t type, uint32_t bytes) {
    put_record_head(out, type, only_node, record_head_bytes + 4 + name.size() + 1 + 4 + bytes, 0, 0);
    put_text(out, name);
    put<uint32_t>(out, bytes);
}

void put_int(std::vector<uint8_t>& out, std::string_view name, uint64_t value) {
    put_property_head(out, name, int_property, 8);
    put<uint64_t>(out, value);
}

void put_mode(std::vector<uint8_t>& out, std::string_view name, const OniFormat& format) {
    put_property_head(out, name, general_property, 12);
    for (const int number : {format.width, format.height, format.fps})
        put<uint32_t>(out, static_cast<uint32_t>(number));
}

}  // namespace

Failure fault_at(const std::string& name, uint64_t offset, const std::string& expected) {
    return Failure{name + ": byte " + std::to_string(offset) + ": expected " + expected};
}

Result<RecordHead> read_record_head(OniBytes& bytes, const std::string& name, uint64_t offset,
                                    uint32_t node) {
    const auto refuse = [&](uint64_t at, const char* expected) {
        return tl::unexpected(fault_at(name, at, expected));
    };
    const auto head = bytes.window(offset, record_head_bytes);
    if (!head) return refuse(bytes.size(), "more of the recording (it ends within a record)");
    const uint8_t* at = head->data();
    if (get<uint32_t>(at) != record_magic) return refuse(offset, "a record (\"NIR\")");
    const RecordHead record = {get<uint32_t>(at + 4), get<uint32_t>(at + 12), get<uint32_t>(at + 16),
                               get<uint64_t>(at + 20)};
    if (get<uint32_t>(at + 8) != node) return refuse(offset + 8, node == 0 ? "node id 0" : "node id 1");
    if (record.fields_bytes < record_head_bytes) return refuse(offset + 12, "a record of at least 28 bytes");
    const uint64_t record_bytes = uint64_t{record.fields_bytes} + record.payload_bytes;
    if (record_bytes > largest_record) return refuse(offset + 12, "a record of at most 5760121 bytes");
    if (record_bytes > bytes.size() - offset)
        return refuse(bytes.size(), "more of the recording (it ends within a record)");
    if (record.undo_at >= offset) return refuse(offset + 20, "an undo position before the record");
    return record;
}

Result<Head> read_head(OniBytes& bytes, const std::string& name) {
    return HeadReader(bytes, name).read();
}

void put_record_head(std::vector<uint8_t>& out, uint32_t type, uint32_t node, size_t fields_bytes,
                     size_t payload_bytes, uint64_t undo_at) {
    put<uint32_t>(out, record_magic);
    put<uint32_t>(out, type);
    put<uint32_t>(out, node);
    put<uint32_t>(out, static_cast<uint32_t>(fields_bytes));
    put<uint32_t>(out, static_cast<uint32_t>(payload_bytes));
    put<uint64_t>(out, undo_at);
}

std::vector<uint8_t> compose_file_header(uint64_t last_us) {
    std::vector<uint8_t> out(file_identity.begin(), file_identity.end());
    put<uint64_t>(out, last_us);
    put<uint32_t>(out, only_node);
    return out;
}

std::vector<uint8_t> compose_node_added(const Head& head) {
    const NodeKind& kind = head.format.infrared ? infrared_node : depth_node;
    std::vector<uint8_t> out;
    put_record_head(out, node_added, only_node, record_head_bytes + 4 + kind.name.size() + 1 + 36, 0, 0);
    put_text(out, kind.name);
    put<uint32_t>(out, kind.type);
    put<uint32_t>(out, four_characters(head.codec));
    put<uint32_t>(out, head.frames);
    put<uint64_t>(out, 0);
    put<uint64_t>(out, head.node_last_us);
    put<uint64_t>(out, head.seek_table_at);
    return out;
}

std::vector<uint8_t> compose_head(Head& head) {
    const OniFormat& format = head.format;
    const uint64_t pixels = static_cast<uint64_t>(format.width) * static_cast<uint64_t>(format.height);
    std::vector<uint8_t> out = compose_file_header(head.header_last_us);
    const std::vector<uint8_t> node = compose_node_added(head);
    out.insert(out.end(), node.begin(), node.end());
    put_int(out, "oniRequiredFrameSize", 2 * pixels);
    put_int(out, "xnIsGenerating", 1);
    if (!format.infrared) put_int(out, "xnDeviceMaxDepth", deepest_value);
    put_int(out, "xnSupportedMapOutputModesCount", 1);
    put_mode(out, "xnSupportedMapOutputModes", format);
    put_mode(out, "xnMapOutputMode", format);
    put_property_head(out, "xnSupportedPixelFormats", general_property, 4);
    put<uint32_t>(out, gray16_bit);
    put_int(out, "xnPixelFormat", gray16);
    put_int(out, "oniPixelFormat", (format.infrared ? infrared_node : depth_node).pixel_format);
    put_property_head(out, "xnFOV", general_property, 16);
    put<double>(out, format.horizontal_fov);
    put<double>(out, format.vertical_fov);
    put_int(out, "Cropping", 1);
    put_property_head(out, "xnCropping", general_property, 12);
    out.resize(out.size() + 12, 0);
    put_int(out, "Mirror", 1);
    put_int(out, "xnMirror", 0);
    put_record_head(out, state_ready, only_node, record_head_bytes, 0, 0);
    put_record_head(out, data_begin, only_node, data_begin_bytes, 0, 0);
    put<uint32_t>(out, open_end_u32);
    put<uint64_t>(out, open_end_u64);
    head.frames_at = out.size();
    return out;
}

}  // namespace deixis::oni
