// The head of a recording, from the first byte to the first frame record: read strictly, or composed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "appliance/sessions/depth_codec.h"
#include "appliance/sessions/oni_bytes.h"
#include "appliance/sessions/oni_writer.h"

namespace deixis::oni {

/// A record's head, checked for magic, node, size and place.
struct RecordHead {
    uint32_t type = 0;
    uint32_t fields_bytes = 0;  ///< the head's 28 included
    uint32_t payload_bytes = 0;
    uint64_t undo_at = 0;
};

/// All of a recording before its frames.
struct Head {
    OniFormat format;
    OniCodec codec = OniCodec::table;
    uint64_t header_last_us = 0;
    uint64_t node_last_us = 0;
    uint32_t frames = 0;
    uint64_t seek_table_at = 0;
    uint64_t frames_at = 0;  ///< first byte after data begin

    bool open_ended() const {
        return header_last_us == ~uint64_t{0} || node_last_us == ~uint64_t{0} || frames == 0xFFFFFFFF;
    }
};

/// "name: byte 98: expected ..."; the form of every complaint about a recording.
Failure fault_at(const std::string& name, uint64_t offset, const std::string& expected);

/// The record head at `offset`; refuses a head that does not lie in the file with its fields and payload,
/// another node than `node`, an undo position not before it, records larger than OpenNI2's buffer.
Result<RecordHead> read_record_head(OniBytes& bytes, const std::string& name, uint64_t offset, uint32_t node);

/// Reads and checks everything up to the first frame record; an open end passes.
Result<Head> read_head(OniBytes& bytes, const std::string& name);

/// The bytes of a head for `format`, its last times and frame count `head.frames` and so on as given.
/// `frames_at` of `head` is set. The size depends on the kind of stream alone, so a head can be written over
/// another.
std::vector<uint8_t> compose_head(Head& head);

/// A record's head as bytes at the end of `out`.
void put_record_head(std::vector<uint8_t>& out, uint32_t type, uint32_t node, size_t fields_bytes,
                     size_t payload_bytes, uint64_t undo_at);

/// The two places of a head that change on closing: header bytes and the node-added record.
std::vector<uint8_t> compose_file_header(uint64_t last_us);
std::vector<uint8_t> compose_node_added(const Head& head);

}  // namespace deixis::oni
