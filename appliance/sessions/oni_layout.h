// The layout of an .oni recording as constants and byte order; shared by writer, walker and mender.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <vector>

namespace deixis::oni {

// File header: "NI10", version 1.0.1.0, largest timestamp (u64), largest node id (u32).
constexpr size_t file_header_bytes = 24;
constexpr std::array<uint8_t, 12> file_identity = {'N', 'I', '1', '0', 1, 0, 1, 0, 0, 0, 0, 0};
constexpr size_t header_last_us_at = 12;

// Record head: magic, type, node, bytes of head and fields, bytes of payload, undo position (u64).
constexpr uint32_t record_magic = 0x0052494E;
constexpr size_t record_head_bytes = 28;
constexpr uint32_t only_node = 1;

enum RecordType : uint32_t {
    int_property = 0x03,
    general_property = 0x06,
    node_removed = 0x07,
    data_begin = 0x08,
    state_ready = 0x09,
    new_data = 0x0A,
    end_record = 0x0B,
    node_added = 0x0D,
    seek_table = 0x0E,
};

constexpr size_t data_begin_bytes = record_head_bytes + 12;
constexpr size_t new_data_bytes = record_head_bytes + 12;
constexpr size_t seek_entry_bytes = 20;

// What OpenNI2's player has buffers for.
constexpr uint64_t largest_record = 5'760'121;
constexpr uint64_t largest_image = 5'760'000;
constexpr int64_t longest_seek_table = 288'003;  // frames; a file of more must do without the table

constexpr uint32_t open_end_u32 = 0xFFFFFFFF;  // frame count while recording
constexpr uint64_t open_end_u64 = ~uint64_t{0};
constexpr int64_t largest_stamp = int64_t{1} << 62;

/// Node type and name of the two kinds of stream that we write and read.
struct NodeKind {
    uint32_t type;
    std::string_view name;
    uint32_t pixel_format;  ///< of OpenNI2
};
constexpr NodeKind depth_node = {2, "Depth", 100};
constexpr NodeKind infrared_node = {5, "IR", 203};

constexpr uint64_t gray16 = 4;              ///< OpenNI 1's pixel format of both
constexpr uint32_t gray16_bit = 8;          ///< the same in a set of formats
constexpr uint64_t deepest_value = 0xFFFF;  ///< MAX_VALUE above every pixel, or the player drops pixels

template <class T>
T get(const uint8_t* at) {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, at, sizeof value);  // the format and every machine we build for are little-endian
    return value;
}

template <class T>
void put(std::vector<uint8_t>& out, std::type_identity_t<T> value) {
    const size_t at = out.size();
    out.resize(at + sizeof(T));
    std::memcpy(out.data() + at, &value, sizeof value);
}

inline void put_text(std::vector<uint8_t>& out, std::string_view text) {
    put<uint32_t>(out, static_cast<uint32_t>(text.size() + 1));
    out.insert(out.end(), text.begin(), text.end());
    out.push_back(0);
}

}  // namespace deixis::oni
