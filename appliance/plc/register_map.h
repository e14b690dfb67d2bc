// The wiring sheet: which register means what between station and PLC. `deixis plc map` prints it from here.
//
// Two blocks of 16-bit registers. Numbers of 32 bits take two registers, the high word first. Texts hold two
// characters a register, the first in the high byte, filled up with NUL.
//
//                             station is the server (default)      station is the client
//   block "to PLC"            input registers, function 4,         holding registers of the PLC, written with
//                             from address 0, read only            function 16 from plc.to_plc_address
//   block "from PLC"          holding registers, functions 3, 6    holding registers of the PLC, read with
//                             and 16, from address 0               function 3 from plc.from_plc_address
//
// Read and write a block in one request: registers of two requests may belong to two moments.
//
// A new part: the PLC writes part_type and part_serial, then another number (not 0) into part_sequence; only
// then does the station take them over, and says so in part_sequence_taken.
//
// A defect: the station fills the registers defect_*, defect_sequence last in meaning: a number other than
// before says that a new defect stands there. The PLC takes it and writes that number into echo_sequence;
// until then the defect stands, and the next one waits. A defect may come twice (after a restart): defect_id
// tells.
//
// Heartbeats: heartbeat changes as long as the station's frame loop runs; when it stops, the status word goes
// to 0. The station takes the PLC for alive while plc_heartbeat changes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "appliance/records/defect_record.h"

namespace deixis {

enum class RegisterBlock { to_plc, from_plc };
enum class RegisterType { bits16, uint16, uint32, int32, ascii };

/// One line of the wiring sheet.
struct RegisterLine {
    RegisterBlock block;
    uint16_t address;  ///< offset in its block
    uint16_t count;    ///< registers
    RegisterType type;
    const char* name;
    const char* unit;
    const char* meaning;
};

inline constexpr uint16_t register_map_version = 1;

// clang-format off
inline constexpr std::array<RegisterLine, 21> register_map{{
    {RegisterBlock::to_plc,    0,  1, RegisterType::bits16, "status",              "",   "status word, bit by bit below; 0 when the station is not running"},
    {RegisterBlock::to_plc,    1,  1, RegisterType::uint16, "heartbeat",           "",   "one more for every frame the station has worked through, 65535 to 0"},
    {RegisterBlock::to_plc,    2,  1, RegisterType::uint16, "map_version",         "",   "version of this sheet"},
    {RegisterBlock::to_plc,    3,  1, RegisterType::uint16, "part_sequence_taken", "",   "part_sequence of the part that the station works with; 0 = none from the PLC"},
    {RegisterBlock::to_plc,    4,  1, RegisterType::uint16, "defect_count",        "",   "defects of the current part, withdrawn ones not counted; 65535 = that many or more"},
    {RegisterBlock::to_plc,    5,  1, RegisterType::uint16, "defects_waiting",     "",   "defects that the PLC has not yet echoed, the standing one included"},
    {RegisterBlock::to_plc,    6,  1, RegisterType::uint16, "defect_sequence",     "",   "1 to 65535, another one for every defect; 0 = no defect stands here"},
    {RegisterBlock::to_plc,    7,  2, RegisterType::uint32, "defect_id",           "",   "number of the defect in the station's record (low 32 bits)"},
    {RegisterBlock::to_plc,    9,  2, RegisterType::int32,  "defect_x",            "mm", "position in the frame of the part's CAD file"},
    {RegisterBlock::to_plc,   11,  2, RegisterType::int32,  "defect_y",            "mm", ""},
    {RegisterBlock::to_plc,   13,  2, RegisterType::int32,  "defect_z",            "mm", ""},
    {RegisterBlock::to_plc,   15,  1, RegisterType::uint16, "defect_zone",         "",   "zone of the part file, counted from 1; 0 = in no zone"},
    {RegisterBlock::to_plc,   16,  1, RegisterType::uint16, "defect_arm",          "",   "1 = worker's left arm, 2 = right arm; 0 = no defect"},
    {RegisterBlock::to_plc,   17,  1, RegisterType::uint16, "defect_confidence",   "%",  "0 to 100"},
    {RegisterBlock::to_plc,   18, 16, RegisterType::ascii,  "defect_serial",       "",   "serial number of the part that the defect lies on"},
    {RegisterBlock::from_plc,  0,  1, RegisterType::uint16, "plc_heartbeat",       "",   "any change says that the PLC runs"},
    {RegisterBlock::from_plc,  1,  1, RegisterType::uint16, "echo_sequence",       "",   "defect_sequence of the last defect that the PLC has taken"},
    {RegisterBlock::from_plc,  2,  1, RegisterType::uint16, "part_sequence",       "",   "another number (not 0) for every part, written after type and serial; 0 = no part"},
    {RegisterBlock::from_plc,  3, 16, RegisterType::ascii,  "part_type",           "",   "type of the part in the cell, up to 32 characters"},
    {RegisterBlock::from_plc, 19, 16, RegisterType::ascii,  "part_serial",         "",   "serial number of the part, up to 32 characters"},
    {RegisterBlock::from_plc, 35,  1, RegisterType::uint16, "reserved",            "",   "write 0"},
}};

/// Bits of the status word.
struct StatusBitLine {
    uint8_t bit;
    const char* name;
    const char* meaning;
};
inline constexpr std::array<StatusBitLine, 9> status_bits{{
    {0, "ready",           "a mark made now would be taken and recorded"},
    {1, "part_locked",     "the part is found and followed"},
    {2, "part_at_rest",    "the part does not move"},
    {3, "sensors_ok",      "all sensors deliver"},
    {4, "database_ok",     "the record can be written"},
    {5, "mark_toggle",     "changes with every mark that is safely in the record"},
    {6, "pointing",        "the worker points at the part"},
    {7, "defect_waiting",  "a defect stands in defect_* that the PLC has not echoed"},
    {8, "plc_heard",       "plc_heartbeat changes"},
}};
// clang-format on

inline constexpr uint16_t to_plc_registers = 34;
inline constexpr uint16_t from_plc_registers = 36;

/// A defect on its way to the PLC.
struct PlcDefect {
    DefectId id = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< part frame [m]
    int zone_number = 0;                                 ///< 1 = first zone of the part file; 0 = none
    ArmSide arm = ArmSide::right;
    double confidence = 0;  ///< 0 to 1
    std::string part_serial;
};

/// The sequence number of a defect, 1 to 65535: made from its id, so that it goes on after a restart. When
/// the PLC shows that very number already (`echoed`: of an earlier record), it would not notice: then the one
/// after it.
uint16_t sequence_of(DefectId id, uint16_t echoed);

/// What the station tells the PLC every frame; the link adds heartbeat, defects and its own bits.
struct PlcOutputs {
    bool ready = false;
    bool part_locked = false;
    bool part_at_rest = false;
    bool sensors_ok = false;
    bool database_ok = false;
    bool mark_toggle = false;
    bool pointing = false;
    int64_t defect_count = 0;          ///< of the current part
    uint16_t part_sequence_taken = 0;  ///< the PLC's number for that part; 0 = none from the PLC
};

/// What the PLC tells the station.
struct PlcInputs {
    uint16_t heartbeat = 0;
    uint16_t echo_sequence = 0;
    uint16_t part_sequence = 0;  ///< of the part below; 0 = the PLC has named no part
    std::string part_type;       ///< printable ASCII, spaces at the end cut
    std::string part_serial;
};

using ToPlcWords = std::array<uint16_t, to_plc_registers>;
using FromPlcWords = std::array<uint16_t, from_plc_registers>;

/// What the link itself knows, for to_words().
struct LinkWords {
    uint16_t heartbeat = 0;
    uint16_t defect_sequence = 0;  ///< of the standing defect
    uint16_t defects_waiting = 0;
    bool plc_heard = false;
    bool station_alive = false;  ///< false: the status word is 0
};

/// Positions beyond +-2,000 km are clamped to it; NaN becomes 0.
ToPlcWords to_words(const PlcOutputs& outputs, const std::optional<PlcDefect>& standing,
                    const LinkWords& link);

/// Bytes that are not printable ASCII become '?'; the text ends at the first NUL.
PlcInputs from_words(const FromPlcWords& words);

/// The other direction, as a PLC would do it: for tests and for trying out.
FromPlcWords to_words(const PlcInputs& inputs);

/// The whole sheet as Markdown tables, or as CSV with one line a register.
std::string register_map_markdown();
std::string register_map_csv();

}  // namespace deixis
