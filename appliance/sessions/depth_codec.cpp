// The pixel codecs of an .oni recording: one 16-bit image to the bytes of its record and back, to the bit.
#include "appliance/sessions/depth_codec.h"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace deixis {
namespace {

// With d = previous - current: |d| <= 6 is the nibble d + 6, two nibbles a byte, high first; 0x66 (two equal
// pixels) is counted and written as 0xE0 + count; |d| <= 63 is the byte 192 + d; anything else the value
// itself, big-endian, which leaves its top bit free to tell the two apart. Before either stands a byte ending
// in 0xF that says so.
constexpr int nibble_reach = 6;
constexpr int byte_reach = 63;
constexpr int byte_middle = 192;
constexpr int largest_jump_target = 32767;
constexpr uint8_t equal_pair = 0x66;
constexpr uint8_t run_base = 0xE0;
constexpr int longest_run = 15;
constexpr uint8_t escape = 0x0F;
constexpr uint8_t ending = 0x0D;

/// Symbols to codes, one after the other. `next` is at most 3 bytes of output.
class CodeWriter {
  public:
    CodeWriter(int first, uint8_t* out) : previous_(first), out_(out) {}

    /// False when `symbol` has no code.
    bool next(int symbol) {
        const int d = previous_ - symbol;
        previous_ = symbol;
        if (d >= -nibble_reach && d <= nibble_reach) {
            put_nibble(d + nibble_reach);
            return true;
        }
        flush_run();
        *out_++ = static_cast<uint8_t>(waiting_ < 0 ? 0xFF : (waiting_ << 4) | escape);
        waiting_ = -1;
        if (d >= -byte_reach && d <= byte_reach) {
            *out_++ = static_cast<uint8_t>(byte_middle + d);
            return true;
        }
        *out_++ = static_cast<uint8_t>(symbol >> 8);
        *out_++ = static_cast<uint8_t>(symbol);
        return symbol <= largest_jump_target;
    }

    uint8_t* end() {
        // The count first: the stock Recorder has these two the wrong way round and so permutes the last
        // pixels.
        flush_run();
        if (waiting_ >= 0) *out_++ = static_cast<uint8_t>((waiting_ << 4) | ending);
        return out_;
    }

  private:
    void put_nibble(int nibble) {
        if (waiting_ < 0) {
            waiting_ = nibble;
            return;
        }
        const auto byte = static_cast<uint8_t>((waiting_ << 4) | nibble);
        waiting_ = -1;
        if (byte != equal_pair) {
            flush_run();
            *out_++ = byte;
        } else if (++run_ == longest_run) {
            flush_run();
        }
    }

    void flush_run() {
        if (run_ == 0) return;
        *out_++ = static_cast<uint8_t>(run_base + run_);
        run_ = 0;
    }

    int previous_;
    int waiting_ = -1;  // the nibble that has no partner yet
    int run_ = 0;       // pairs of equal pixels not yet written
    uint8_t* out_;
};

void put_u16(uint8_t*& out, uint16_t value) {
    *out++ = static_cast<uint8_t>(value);
    *out++ = static_cast<uint8_t>(value >> 8);
}

uint16_t u16_at(const uint8_t* p) {
    return static_cast<uint16_t>(p[0] | (p[1] << 8));
}

/// Codes to symbols in [0, limit), each given to `value_of` on its way into a pixel.
template <class ValueOf>
std::optional<CodecFault> decode_codes(std::span<const uint8_t> coded, size_t at, int limit,
                                       std::span<uint16_t> pixels, ValueOf value_of) {
    constexpr const char* more_pixels = "no more pixels than the image has";
    constexpr const char* in_range = "a value inside the table (16zT) or below 65536 (16zP)";
    constexpr const char* more_bytes = "more coded bytes";
    if (coded.size() < at + 2) return CodecFault{at, "the first value, two bytes"};
    int symbol = u16_at(&coded[at]);
    if (symbol >= limit) return CodecFault{at, in_range};
    at += 2;
    const size_t count = pixels.size();
    size_t done = 0;
    pixels[done++] = value_of(symbol);
    while (at < coded.size()) {
        const uint8_t byte = coded[at];
        if (byte >= run_base && byte != 0xFF) {
            const size_t equal = 2 * static_cast<size_t>(byte - run_base);
            if (equal == 0) return CodecFault{at, "a run of at least one pair"};
            if (equal > count - done) return CodecFault{at, more_pixels};
            std::fill_n(pixels.begin() + static_cast<std::ptrdiff_t>(done), equal, value_of(symbol));
            done += equal;
            ++at;
            continue;
        }
        const int high = byte >> 4;
        const int low = byte & 0x0F;
        if (byte != 0xFF) {
            if (high > 2 * nibble_reach)
                return CodecFault{at, "a difference of at most 6 in the high nibble"};
            if (done == count) return CodecFault{at, more_pixels};
            symbol += nibble_reach - high;
            if (symbol < 0 || symbol >= limit) return CodecFault{at, in_range};
            pixels[done++] = value_of(symbol);
        }
        ++at;
        if (low == ending) {
            // Ours ends here; the Recorder's may have one run left.
            const bool last = at == coded.size() || (at + 1 == coded.size() && coded[at] >= run_base);
            if (!last) return CodecFault{at, "the end after a lone nibble"};
            continue;
        }
        if (done == count) return CodecFault{at - 1, more_pixels};
        if (low <= 2 * nibble_reach) {
            symbol += nibble_reach - low;
        } else if (low == escape) {
            if (at == coded.size()) return CodecFault{at, more_bytes};
            if (coded[at] >= 0x80) {
                symbol -= coded[at++] - byte_middle;
            } else {
                if (at + 1 == coded.size()) return CodecFault{at + 1, more_bytes};
                symbol = (coded[at] << 8) | coded[at + 1];
                at += 2;
            }
        } else {
            return CodecFault{at - 1, "a difference of at most 6, 0xD or 0xF in the low nibble"};
        }
        if (symbol < 0 || symbol >= limit) return CodecFault{at - 1, in_range};
        pixels[done++] = value_of(symbol);
    }
    if (done != count) return CodecFault{coded.size(), "as many pixels as the image has"};
    return std::nullopt;
}

std::optional<CodecFault> decode_table(std::span<const uint8_t> coded, std::span<uint16_t> pixels) {
    if (coded.size() < 2) return CodecFault{0, "the table's size, two bytes"};
    const size_t entries = u16_at(coded.data());
    if (entries == 0) return CodecFault{0, "a table of at least one value"};
    if (coded.size() < 2 + 2 * entries) return CodecFault{coded.size(), "the whole table"};
    const uint8_t* table = coded.data() + 2;
    for (size_t i = 1; i < entries; ++i)
        if (u16_at(table + 2 * i) <= u16_at(table + 2 * i - 2))
            return CodecFault{2 + 2 * i, "an ascending table"};
    return decode_codes(coded, 2 + 2 * entries, static_cast<int>(entries), pixels,
                        [table](int index) { return u16_at(table + 2 * static_cast<size_t>(index)); });
}

}  // namespace

const char* name_of(OniCodec codec) {
    switch (codec) {
        case OniCodec::none:
            return "NONE";
        case OniCodec::differences:
            return "16zP";
        case OniCodec::table:
            return "16zT";
    }
    return "";
}

bool DepthEncoder::encode(OniCodec codec, std::span<const uint16_t> pixels, std::vector<uint8_t>& out) {
    assert(!pixels.empty());
    if (codec == OniCodec::none) {
        out.resize(2 * pixels.size());
        uint8_t* at = out.data();
        for (const uint16_t pixel : pixels) put_u16(at, pixel);
        return true;
    }
    if (codec == OniCodec::differences) {
        out.resize(3 * pixels.size() + 4);
        uint8_t* at = out.data();
        put_u16(at, pixels[0]);
        CodeWriter codes(pixels[0], at);
        bool all_coded = true;
        for (size_t i = 1; i < pixels.size(); ++i) all_coded &= codes.next(pixels[i]);
        out.resize(static_cast<size_t>(codes.end() - out.data()));
        return all_coded;
    }
    seen_.resize(65536, 0);
    index_of_value_.resize(65536);
    for (const uint16_t pixel : pixels) seen_[pixel] = 1;
    out.resize(3 * pixels.size() + 4 + size_t{2} * 65536);
    uint8_t* at = out.data() + 2;
    size_t entries = 0;
    for (size_t value = 0; value < 65536; ++value) {
        if (seen_[value] == 0) continue;
        seen_[value] = 0;
        index_of_value_[value] = static_cast<uint16_t>(entries++);
        put_u16(at, static_cast<uint16_t>(value));
    }
    if (entries > 65535) return false;  // the count is 16 bits wide
    uint8_t* count_at = out.data();
    put_u16(count_at, static_cast<uint16_t>(entries));
    put_u16(at, index_of_value_[pixels[0]]);
    CodeWriter codes(index_of_value_[pixels[0]], at);
    bool all_coded = true;
    for (size_t i = 1; i < pixels.size(); ++i) all_coded &= codes.next(index_of_value_[pixels[i]]);
    out.resize(static_cast<size_t>(codes.end() - out.data()));
    return all_coded;
}

std::optional<CodecFault> decode_depth(OniCodec codec, std::span<const uint8_t> coded,
                                       std::span<uint16_t> pixels) {
    assert(!pixels.empty());
    if (codec == OniCodec::table) return decode_table(coded, pixels);
    if (codec == OniCodec::differences)
        return decode_codes(coded, 0, 65536, pixels, [](int value) { return static_cast<uint16_t>(value); });
    if (coded.size() != 2 * pixels.size())
        return CodecFault{std::min(coded.size(), 2 * pixels.size()), "exactly two bytes a pixel"};
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = u16_at(&coded[2 * i]);
    return std::nullopt;
}

}  // namespace deixis
