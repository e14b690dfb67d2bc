// The register map as a document: Markdown for people, CSV for a PLC programmer's import.
#include <string>

#include "appliance/plc/register_map.h"

namespace deixis {
namespace {

const char* name_of(RegisterType type) {
    switch (type) {
        case RegisterType::bits16:
            return "bits";
        case RegisterType::uint16:
            return "uint16";
        case RegisterType::uint32:
            return "uint32";
        case RegisterType::int32:
            return "int32";
        case RegisterType::ascii:
            return "ASCII";
    }
    return "";
}

const char* name_of(RegisterBlock block) {
    return block == RegisterBlock::to_plc ? "to PLC" : "from PLC";
}

std::string addresses(const RegisterLine& line) {
    if (line.count == 1) return std::to_string(line.address);
    return std::to_string(line.address) + "-" + std::to_string(line.address + line.count - 1);
}

/// A line without meaning of its own goes on with the one above it.
std::string meaning_of(const RegisterLine& line) {
    return line.meaning[0] != '\0' ? line.meaning : "as above";
}

std::string markdown_block(RegisterBlock block) {
    std::string table = "| offset | type | name | unit | meaning |\n| --- | --- | --- | --- | --- |\n";
    for (const RegisterLine& line : register_map) {
        if (line.block != block) continue;
        table += "| " + addresses(line) + " | " + name_of(line.type) + " | `" + line.name + "` | " +
                 line.unit + " | " + meaning_of(line) + " |\n";
    }
    return table;
}

}  // namespace

std::string register_map_markdown() {
    std::string sheet = "# Register map, version " + std::to_string(register_map_version) + "\n\n";
    sheet +=
        "Modbus TCP, 16-bit registers, addresses from 0. Numbers of 32 bits take two registers, the high "
        "word "
        "first. Texts hold two characters a register, the first in the high byte, filled up with NUL. Read "
        "and "
        "write a block in one request.\n\n";
    sheet +=
        "## To the PLC\n\nStation is the server: input registers (function 4) from 0. Station is the client: "
        "it "
        "writes the PLC's holding registers (function 16) from `plc.to_plc_address`.\n\n";
    sheet += markdown_block(RegisterBlock::to_plc) +
             "\nStatus word:\n\n| bit | name | meaning |\n| --- | --- | --- |\n";
    for (const StatusBitLine& line : status_bits)
        sheet += "| " + std::to_string(line.bit) + " | `" + line.name + "` | " + line.meaning + " |\n";
    sheet +=
        "\n## From the PLC\n\nStation is the server: holding registers (functions 3, 6, 16) from 0. Station "
        "is the "
        "client: it reads the PLC's holding registers (function 3) from `plc.from_plc_address`.\n\n";
    sheet += markdown_block(RegisterBlock::from_plc);
    sheet +=
        "\n## A new part\n\nWrite `part_type` and `part_serial`, then another number (not 0) into "
        "`part_sequence`. The station has taken the part over when `part_sequence_taken` shows that number; "
        "`defect_count` is then that part's. 0 says that no part is there.\n\n"
        "## A defect\n\nA `defect_sequence` other than before says that a new defect stands in `defect_*`. "
        "Take it, then write that number into `echo_sequence`; until then it stands, and the next one waits. "
        "Write the block once before the first echo: what stands there at first is never taken for an echo. "
        "A "
        "defect may come twice, after a restart: compare `defect_id`.\n\n"
        "## Heartbeats\n\n`heartbeat` changes as long as the station's loop runs; when it stops, the status "
        "word goes to 0. The station takes the PLC for alive while `plc_heartbeat` changes.\n";
    return sheet;
}

std::string register_map_csv() {
    std::string csv = "block,offset,registers,type,name,unit,meaning\r\n";
    for (const RegisterLine& line : register_map)
        csv += std::string(name_of(line.block)) + "," + std::to_string(line.address) + "," +
               std::to_string(line.count) + "," + name_of(line.type) + "," + line.name + "," + line.unit +
               ",\"" + meaning_of(line) + "\"\r\n";
    for (const StatusBitLine& line : status_bits)
        csv +=
            "to PLC,0." + std::to_string(line.bit) + ",,bit," + line.name + ",,\"" + line.meaning + "\"\r\n";
    return csv;
}

}  // namespace deixis
