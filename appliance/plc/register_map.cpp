// Values to registers and back, exactly as the wiring sheet says.
#include "appliance/plc/register_map.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

namespace deixis {
namespace {

constexpr const RegisterLine& line_of(std::string_view name) {
    for (const RegisterLine& line : register_map)
        if (line.name == name) return line;
    throw "no such register";  // at compile time only
}

/// The sheet itself is checked by the compiler: blocks without gap or overlap, of the stated length.
constexpr bool covers(RegisterBlock block, uint16_t registers) {
    uint16_t next = 0;
    for (const RegisterLine& line : register_map) {
        if (line.block != block) continue;
        if (line.address != next) return false;
        next = static_cast<uint16_t>(line.address + line.count);
    }
    return next == registers;
}
static_assert(covers(RegisterBlock::to_plc, to_plc_registers));
static_assert(covers(RegisterBlock::from_plc, from_plc_registers));

constexpr uint16_t status = line_of("status").address, heartbeat = line_of("heartbeat").address,
                   map_version = line_of("map_version").address,
                   part_sequence_taken = line_of("part_sequence_taken").address,
                   defect_count = line_of("defect_count").address,
                   defects_waiting = line_of("defects_waiting").address,
                   defect_sequence = line_of("defect_sequence").address,
                   defect_id = line_of("defect_id").address, defect_x = line_of("defect_x").address,
                   defect_zone = line_of("defect_zone").address, defect_arm = line_of("defect_arm").address,
                   defect_confidence = line_of("defect_confidence").address,
                   plc_heartbeat = line_of("plc_heartbeat").address,
                   echo_sequence = line_of("echo_sequence").address,
                   part_sequence = line_of("part_sequence").address;

constexpr uint16_t bit_of(std::string_view name) {
    for (const StatusBitLine& line : status_bits)
        if (line.name == name) return static_cast<uint16_t>(1U << line.bit);
    throw "no such bit";  // at compile time only
}

uint16_t status_word(const PlcOutputs& outputs, bool defect_stands, const LinkWords& link) {
    if (!link.station_alive) return 0;
    int word = 0;
    const auto set = [&word](bool on, uint16_t bit) { word |= on ? bit : 0; };
    set(outputs.ready, bit_of("ready"));
    set(outputs.part_locked, bit_of("part_locked"));
    set(outputs.part_at_rest, bit_of("part_at_rest"));
    set(outputs.sensors_ok, bit_of("sensors_ok"));
    set(outputs.database_ok, bit_of("database_ok"));
    set(outputs.mark_toggle, bit_of("mark_toggle"));
    set(outputs.pointing, bit_of("pointing"));
    set(defect_stands, bit_of("defect_waiting"));
    set(link.plc_heard, bit_of("plc_heard"));
    return static_cast<uint16_t>(word);
}

template <class Words>
void put_32(Words& words, uint16_t address, uint32_t value) {
    words[address] = static_cast<uint16_t>(value >> 16);
    words[address + 1] = static_cast<uint16_t>(value & 0xFFFF);
}

template <class Words>
void put_text(Words& words, const RegisterLine& line, const std::string& text) {
    const auto byte = [&](size_t i) -> unsigned {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
    };
    for (size_t i = 0; i < line.count; ++i)
        words[line.address + i] = static_cast<uint16_t>(byte(2 * i) << 8 | byte(2 * i + 1));
}

std::string text_at(const FromPlcWords& words, const RegisterLine& line) {
    std::string text;
    for (size_t i = 0; i < 2U * line.count; ++i) {
        const uint16_t word = words[line.address + i / 2];
        const char c = static_cast<char>(i % 2 == 0 ? word >> 8 : word & 0xFF);
        if (c == '\0') break;
        text += c >= ' ' && c <= '~' ? c : '?';
    }
    text.erase(text.find_last_not_of(' ') + 1);
    return text;
}

int32_t whole_mm(double metres) {
    if (std::isnan(metres)) return 0;
    return static_cast<int32_t>(std::lround(std::clamp(1000.0 * metres, -2e9, 2e9)));
}

}  // namespace

uint16_t sequence_of(DefectId id, uint16_t echoed) {
    const auto nth = [](DefectId n) { return static_cast<uint16_t>((n - 1) % 65535 + 1); };
    const uint16_t sequence = nth(std::max<DefectId>(id, 1));
    return sequence == echoed ? nth(DefectId{sequence} + 1) : sequence;
}

ToPlcWords to_words(const PlcOutputs& outputs, const std::optional<PlcDefect>& standing,
                    const LinkWords& link) {
    ToPlcWords words{};
    words[status] = status_word(outputs, standing.has_value(), link);
    words[heartbeat] = link.heartbeat;
    words[map_version] = register_map_version;
    words[part_sequence_taken] = outputs.part_sequence_taken;
    words[defect_count] = static_cast<uint16_t>(std::clamp<int64_t>(outputs.defect_count, 0, 65535));
    words[defects_waiting] = link.defects_waiting;
    if (!standing) return words;
    words[defect_sequence] = link.defect_sequence;
    put_32(words, defect_id, static_cast<uint32_t>(standing->id & 0xFFFFFFFF));
    for (int axis = 0; axis < 3; ++axis)
        put_32(words, static_cast<uint16_t>(defect_x + 2 * axis),
               static_cast<uint32_t>(whole_mm(standing->position[axis])));
    words[defect_zone] = static_cast<uint16_t>(std::clamp(standing->zone_number, 0, 65535));
    words[defect_arm] = standing->arm == ArmSide::left ? 1 : 2;
    const double confidence =
        std::isnan(standing->confidence) ? 0.0 : std::clamp(standing->confidence, 0.0, 1.0);
    words[defect_confidence] = static_cast<uint16_t>(std::lround(100 * confidence));
    put_text(words, line_of("defect_serial"), standing->part_serial);
    return words;
}

PlcInputs from_words(const FromPlcWords& words) {
    PlcInputs inputs;
    inputs.heartbeat = words[plc_heartbeat];
    inputs.echo_sequence = words[echo_sequence];
    inputs.part_sequence = words[part_sequence];
    inputs.part_type = text_at(words, line_of("part_type"));
    inputs.part_serial = text_at(words, line_of("part_serial"));
    return inputs;
}

FromPlcWords to_words(const PlcInputs& inputs) {
    FromPlcWords words{};
    words[plc_heartbeat] = inputs.heartbeat;
    words[echo_sequence] = inputs.echo_sequence;
    words[part_sequence] = inputs.part_sequence;
    put_text(words, line_of("part_type"), inputs.part_type);
    put_text(words, line_of("part_serial"), inputs.part_serial);
    return words;
}

}  // namespace deixis
