// Networks as address and mask; an entry that would allow everybody must say so ("0.0.0.0/0").
#include "appliance/plc/address_list.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace deixis {
namespace {

/// The whole of `text` as a decimal number of at most `highest`, without sign or superfluous zeros.
std::optional<uint32_t> small_number(std::string_view text, uint32_t highest) {
    uint32_t value = 0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
    if (end.ec != std::errc() || end.ptr != text.data() + text.size() || value > highest) return std::nullopt;
    if (text.size() > 1 && text.front() == '0') return std::nullopt;
    return value;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    return text;
}

}  // namespace

std::optional<uint32_t> ipv4_of(const std::string& text) {
    std::string_view rest = text;
    uint32_t address = 0;
    for (int octet = 0; octet < 4; ++octet) {
        const size_t dot = octet < 3 ? rest.find('.') : rest.size();
        if (dot == std::string_view::npos) return std::nullopt;
        const auto value = small_number(rest.substr(0, dot), 255);
        if (!value) return std::nullopt;
        address = address << 8 | *value;
        rest.remove_prefix(octet < 3 ? dot + 1 : dot);
    }
    return address;
}

std::string ipv4_text(uint32_t address) {
    return std::to_string(address >> 24) + "." + std::to_string(address >> 16 & 255) + "." +
           std::to_string(address >> 8 & 255) + "." + std::to_string(address & 255);
}

Result<AddressList> AddressList::read(const std::string& text) {
    AddressList list;
    std::string_view rest = text;
    while (!trimmed(rest).empty()) {
        const size_t comma = std::min(rest.find(','), rest.size());
        const std::string_view entry = trimmed(rest.substr(0, comma));
        rest.remove_prefix(std::min(comma + 1, rest.size()));
        const size_t slash = entry.find('/');
        const auto address = ipv4_of(std::string(entry.substr(0, slash)));
        const auto bits = slash == std::string_view::npos ? std::optional<uint32_t>(32)
                                                          : small_number(entry.substr(slash + 1), 32);
        if (!address || !bits)
            return fail(std::string(entry).insert(0, 1, '"') +
                        "\" is not an IPv4 address or network; expected as 192.168.3.7 or 192.168.3.0/24");
        const uint32_t mask = *bits == 0 ? 0 : ~uint32_t{0} << (32 - *bits);
        list.networks_.push_back({*address & mask, mask});
    }
    return list;
}

bool AddressList::allows(uint32_t address) const {
    for (const Network& network : networks_)
        if ((address & network.mask) == network.address) return true;
    return false;
}

}  // namespace deixis
