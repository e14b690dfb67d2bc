// The 16z codes as the format description puts them, one rule after the other: slow, to compare the real
// codec with.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

namespace deixis::testing {

using Symbols = std::vector<int>;
using CodedBytes = std::vector<uint8_t>;

inline void plain_append_u16(CodedBytes& out, int value) {
    out.push_back(static_cast<uint8_t>(value % 256));
    out.push_back(static_cast<uint8_t>(value / 256));
}

/// First a list of codes (nibbles, bytes, values), then the bytes.
inline std::optional<CodedBytes> plain_encode_symbols(const Symbols& symbols) {
    CodedBytes out;
    plain_append_u16(out, symbols[0]);
    std::vector<int> waiting;  // at most one nibble
    int equal_pairs = 0;
    const auto write_count = [&] {
        if (equal_pairs > 0) out.push_back(static_cast<uint8_t>(0xE0 + equal_pairs));
        equal_pairs = 0;
    };
    for (size_t i = 1; i < symbols.size(); ++i) {
        const int d = symbols[i - 1] - symbols[i];
        if (std::abs(d) <= 6) {
            waiting.push_back(d + 6);
            if (waiting.size() < 2) continue;
            const int byte = waiting[0] * 16 + waiting[1];
            waiting.clear();
            if (byte == 0x66) {
                ++equal_pairs;
                if (equal_pairs == 15) write_count();
            } else {
                write_count();
                out.push_back(static_cast<uint8_t>(byte));
            }
            continue;
        }
        write_count();
        out.push_back(static_cast<uint8_t>(waiting.empty() ? 0xFF : waiting[0] * 16 + 0xF));
        waiting.clear();
        if (std::abs(d) <= 63) {
            out.push_back(static_cast<uint8_t>(192 + d));
        } else {
            if (symbols[i] > 32767) return std::nullopt;
            out.push_back(static_cast<uint8_t>(symbols[i] / 256));
            out.push_back(static_cast<uint8_t>(symbols[i] % 256));
        }
    }
    write_count();
    if (!waiting.empty()) out.push_back(static_cast<uint8_t>(waiting[0] * 16 + 0xD));
    return out;
}

inline std::optional<CodedBytes> plain_encode_differences(const std::vector<uint16_t>& pixels) {
    return plain_encode_symbols(Symbols(pixels.begin(), pixels.end()));
}

inline std::optional<CodedBytes> plain_encode_table(const std::vector<uint16_t>& pixels) {
    const std::set<uint16_t> values(pixels.begin(), pixels.end());
    if (values.size() > 65535) return std::nullopt;
    CodedBytes out;
    plain_append_u16(out, static_cast<int>(values.size()));
    for (const uint16_t value : values) plain_append_u16(out, value);
    const std::vector<uint16_t> table(values.begin(), values.end());
    Symbols indices;
    for (const uint16_t pixel : pixels)
        indices.push_back(
            static_cast<int>(std::lower_bound(table.begin(), table.end(), pixel) - table.begin()));
    const auto codes = plain_encode_symbols(indices);
    if (!codes) return std::nullopt;
    out.insert(out.end(), codes->begin(), codes->end());
    return out;
}

}  // namespace deixis::testing
