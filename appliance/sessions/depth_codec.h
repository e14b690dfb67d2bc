// The pixel codecs of an .oni recording: one 16-bit image to the bytes of its record and back, to the bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace deixis {

/// How the pixels of a recording are coded. `none`: as they lie in memory, little-endian. `differences`
/// ("16zP"): differences of neighbours in 4 or 8 bits. `table` ("16zT"): the frame's distinct values, then
/// differences of their indices; the smallest of the three for depth and what OpenNI2's own Recorder writes.
enum class OniCodec { none, differences, table };

/// Four characters in file order: "NONE", "16zP", "16zT".
const char* name_of(OniCodec codec);

/// The first thing wrong in coded pixels.
struct CodecFault {
    size_t offset = 0;          ///< byte in the payload
    const char* expected = "";  ///< what should have stood there
};

/// Codes images with buffers that are kept from call to call. One object a thread; results do not depend on
/// what was coded before.
class DepthEncoder {
  public:
    /// Replaces `out` by the coded pixels (row order, at least one). False, with `out` unspecified, when the
    /// codec has no code for them: a jump of more than 63 to a value (differences) or index (table) above
    /// 32767, or 65536 distinct values (table). `none` codes everything. Never writes more than 3 bytes a
    /// pixel plus 2 a table entry plus 4.
    bool encode(OniCodec codec, std::span<const uint16_t> pixels, std::vector<uint8_t>& out);

  private:
    std::vector<uint16_t> index_of_value_;  ///< 65536 entries; only those of the current frame mean something
    std::vector<uint8_t> seen_;             ///< 65536 flags, all zero between calls
};

/// Decodes `coded` into exactly `pixels.size()` pixels. Strict: no overrun, no value or index out of range,
/// an ascending table, no byte left over, no code that no encoder writes; the Recorder's own end (waiting
/// nibble before the last run, which permutes a few pixels) is read as OpenNI2's player reads it. `pixels` is
/// unspecified after a fault.
std::optional<CodecFault> decode_depth(OniCodec codec, std::span<const uint8_t> coded,
                                       std::span<uint16_t> pixels);

}  // namespace deixis
