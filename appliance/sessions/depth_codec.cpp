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

/// Codes to symbols in [0, limit), each turned into a pixel by `value_of`.
template <class ValueOf>
class CodeReader {
  public:
    CodeReader(std::span<const uint8_t> coded, size_t at, int limit, std::span<uint16_t> pixels,
               ValueOf value_of)
        : coded_(coded), pixels_(pixels), at_(at), limit_(limit), value_of_(value_of) {}

    std::optional<CodecFault> read() {
        if (coded_.size() < at_ + 2) return CodecFault{at_, "the first value, two bytes"};
        const size_t first_at = at_;
        at_ += 2;
        if (!put(u16_at(&coded_[first_at]), first_at)) return fault_;
        while (at_ < coded_.size()) {
            const uint8_t byte = coded_[at_];
            const bool run = byte >= run_base && byte != 0xFF;
            if (run ? !read_run(byte) : !read_pair(byte)) return fault_;
        }
        if (done_ != pixels_.size()) return CodecFault{coded_.size(), "as many pixels as the image has"};
        return std::nullopt;
    }

  private:
    bool refuse(size_t at, const char* expected) {
        fault_ = {at, expected};
        return false;
    }

    bool put(int symbol, size_t code_at) {
        if (done_ == pixels_.size()) return refuse(code_at, "no more pixels than the image has");
        if (symbol < 0 || symbol >= limit_)
            return refuse(code_at, "a value inside the table (16zT) or below 65536 (16zP)");
        symbol_ = symbol;
        pixels_[done_++] = value_of_(symbol);
        return true;
    }

    bool read_run(uint8_t byte) {
        const size_t equal = 2 * static_cast<size_t>(byte - run_base);
        if (equal == 0) return refuse(at_, "a run of at least one pair");
        if (equal > pixels_.size() - done_) return refuse(at_, "no more pixels than the image has");
        std::fill_n(pixels_.begin() + static_cast<std::ptrdiff_t>(done_), equal, value_of_(symbol_));
        done_ += equal;
        ++at_;
        return true;
    }

    /// The nibbles of `byte` and, behind an escape, the byte or value that they announce.
    bool read_pair(uint8_t byte) {
        const size_t byte_at = at_++;
        if (byte != 0xFF) {
            const int high = byte >> 4;
            if (high > 2 * nibble_reach)
                return refuse(byte_at, "a difference of at most 6 in the high nibble");
            if (!put(symbol_ + nibble_reach - high, byte_at)) return false;
        }
        const int low = byte & 0x0F;
        if (low <= 2 * nibble_reach) return put(symbol_ + nibble_reach - low, byte_at);
        if (low == escape) return read_escaped();
        if (low != ending) return refuse(byte_at, "a difference of at most 6, 0xD or 0xF in the low nibble");
        // Ours ends here; the Recorder's may have one run left.
        const bool last = at_ == coded_.size() || (at_ + 1 == coded_.size() && coded_[at_] >= run_base);
        return last || refuse(at_, "the end after a lone nibble");
    }

    bool read_escaped() {
        const size_t code_at = at_;
        const size_t left = coded_.size() - at_;
        if (left == 0 || (coded_[at_] < 0x80 && left == 1)) return refuse(coded_.size(), "more coded bytes");
        if (coded_[at_] >= 0x80) {
            at_ += 1;
            return put(symbol_ - (coded_[code_at] - byte_middle), code_at);
        }
        at_ += 2;
        return put((coded_[code_at] << 8) | coded_[code_at + 1], code_at);
    }

    std::span<const uint8_t> coded_;
    std::span<uint16_t> pixels_;
    size_t at_;
    size_t done_ = 0;
    int limit_;
    int symbol_ = 0;
    ValueOf value_of_;
    CodecFault fault_;
};

std::optional<CodecFault> decode_table(std::span<const uint8_t> coded, std::span<uint16_t> pixels) {
    if (coded.size() < 2) return CodecFault{0, "the table's size, two bytes"};
    const size_t entries = u16_at(coded.data());
    if (entries == 0) return CodecFault{0, "a table of at least one value"};
    if (coded.size() < 2 + 2 * entries) return CodecFault{coded.size(), "the whole table"};
    const uint8_t* table = coded.data() + 2;
    for (size_t i = 1; i < entries; ++i)
        if (u16_at(table + 2 * i) <= u16_at(table + 2 * i - 2))
            return CodecFault{2 + 2 * i, "an ascending table"};
    const auto value_of = [table](int index) { return u16_at(table + 2 * static_cast<size_t>(index)); };
    return CodeReader(coded, 2 + 2 * entries, static_cast<int>(entries), pixels, value_of).read();
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
    out.resize(3 * pixels.size() + 4 + 2 * std::min(pixels.size(), size_t{65536}));
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
        return CodeReader(coded, 0, 65536, pixels, [](int value) { return static_cast<uint16_t>(value); })
            .read();
    if (coded.size() != 2 * pixels.size())
        return CodecFault{std::min(coded.size(), 2 * pixels.size()), "exactly two bytes a pixel"};
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = u16_at(&coded[2 * i]);
    return std::nullopt;
}

}  // namespace deixis
