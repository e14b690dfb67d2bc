// Values to registers and back, the sequence numbers, and a wiring sheet that names every register.
#include "appliance/plc/register_map.h"

#include <gmock/gmock.h>

#include <limits>

namespace deixis {
namespace {

using ::testing::HasSubstr;

const RegisterLine& line_of(const std::string& name) {
    for (const RegisterLine& line : register_map)
        if (name == line.name) return line;
    throw std::out_of_range(name);
}

int32_t signed_at(const ToPlcWords& words, const std::string& name) {
    const uint16_t at = line_of(name).address;
    return static_cast<int32_t>(uint32_t{words[at]} << 16 | words[at + 1]);
}

PlcDefect sample_defect() {
    PlcDefect defect;
    defect.id = 70'000;
    defect.position = {0.3104, -0.85049, 12.0};
    defect.zone_number = 3;
    defect.arm = ArmSide::left;
    defect.confidence = 0.876;
    defect.part_serial = "SN-42x";
    return defect;
}

TEST(RegisterMap, PlacesADefectAsTheSheetSays) {
    LinkWords link;
    link.heartbeat = 65535;
    link.defects_waiting = 2;
    link.defect_sequence = 4465;
    PlcOutputs outputs;
    outputs.defect_count = 70'000;
    outputs.part_sequence_taken = 9;
    const ToPlcWords words = to_words(outputs, sample_defect(), link);
    EXPECT_EQ(words[line_of("heartbeat").address], 65535);
    EXPECT_EQ(words[line_of("map_version").address], register_map_version);
    EXPECT_EQ(words[line_of("part_sequence_taken").address], 9);
    EXPECT_EQ(words[line_of("defect_count").address], 65535) << "clamped";
    EXPECT_EQ(words[line_of("defects_waiting").address], 2);
    EXPECT_EQ(words[line_of("defect_sequence").address], 4465);
    EXPECT_EQ(words[7], 1);  // 70,000 = 1 * 65,536 + 4,464: the high word first
    EXPECT_EQ(words[8], 4464);
    EXPECT_EQ(signed_at(words, "defect_x"), 310);
    EXPECT_EQ(signed_at(words, "defect_y"), -850);
    EXPECT_EQ(signed_at(words, "defect_z"), 12'000);
    EXPECT_EQ(words[line_of("defect_zone").address], 3);
    EXPECT_EQ(words[line_of("defect_arm").address], 1);
    EXPECT_EQ(words[line_of("defect_confidence").address], 88);
    EXPECT_EQ(words[18], 'S' << 8 | 'N');
    EXPECT_EQ(words[20], '2' << 8 | 'x');
    EXPECT_EQ(words[21], 0);
}

TEST(RegisterMap, SetsEachStatusBitAloneAndNoneWhenTheStationStandsStill) {
    const auto status = [](void (*set)(PlcOutputs&, LinkWords&), bool stands, bool alive) {
        PlcOutputs outputs;
        LinkWords link;
        link.station_alive = alive;
        set(outputs, link);
        return to_words(outputs, stands ? std::optional(sample_defect()) : std::nullopt, link)[0];
    };
    void (*const setters[])(PlcOutputs&, LinkWords&) = {
        [](PlcOutputs& o, LinkWords&) { o.ready = true; },
        [](PlcOutputs& o, LinkWords&) { o.part_locked = true; },
        [](PlcOutputs& o, LinkWords&) { o.part_at_rest = true; },
        [](PlcOutputs& o, LinkWords&) { o.sensors_ok = true; },
        [](PlcOutputs& o, LinkWords&) { o.database_ok = true; },
        [](PlcOutputs& o, LinkWords&) { o.mark_toggle = true; },
        [](PlcOutputs& o, LinkWords&) { o.pointing = true; },
        [](PlcOutputs&, LinkWords&) {},
        [](PlcOutputs&, LinkWords& l) { l.plc_heard = true; },
    };
    for (size_t bit = 0; bit < std::size(setters); ++bit) {
        const bool stands = std::string(status_bits[bit].name) == "defect_waiting";
        EXPECT_EQ(status_bits[bit].bit, bit);
        EXPECT_EQ(status(setters[bit], stands, true), 1U << bit) << status_bits[bit].name;
        EXPECT_EQ(status(setters[bit], stands, false), 0) << status_bits[bit].name;
    }
}

TEST(RegisterMap, ClampsWhatDoesNotFit) {
    PlcDefect defect = sample_defect();
    defect.position = {1e9, -1e9, std::numeric_limits<double>::quiet_NaN()};
    defect.confidence = std::numeric_limits<double>::quiet_NaN();
    defect.zone_number = -1;
    defect.part_serial = std::string(100, 'x');
    const ToPlcWords words = to_words(PlcOutputs{}, defect, LinkWords{});
    EXPECT_EQ(signed_at(words, "defect_x"), 2'000'000'000);
    EXPECT_EQ(signed_at(words, "defect_y"), -2'000'000'000);
    EXPECT_EQ(signed_at(words, "defect_z"), 0);
    EXPECT_EQ(words[line_of("defect_zone").address], 0);
    EXPECT_EQ(words[line_of("defect_confidence").address], 0);
    EXPECT_EQ(words[to_plc_registers - 1], 'x' << 8 | 'x');
}

TEST(RegisterMap, ReadsBackWhatAPlcWrites) {
    PlcInputs inputs;
    inputs.heartbeat = 7;
    inputs.echo_sequence = 65535;
    inputs.part_sequence = 300;
    inputs.part_type = "bumper-front-a";
    inputs.part_serial = std::string(32, 'S');
    const PlcInputs read = from_words(to_words(inputs));
    EXPECT_EQ(read.heartbeat, 7);
    EXPECT_EQ(read.echo_sequence, 65535);
    EXPECT_EQ(read.part_sequence, 300);
    EXPECT_EQ(read.part_type, inputs.part_type);
    EXPECT_EQ(read.part_serial, inputs.part_serial);
}

TEST(RegisterMap, MakesForeignTextsPrintable) {
    PlcInputs inputs;
    inputs.part_serial = "a\nb\xff\x01 c   ";
    inputs.part_type = "    ";
    const PlcInputs read = from_words(to_words(inputs));
    EXPECT_EQ(read.part_serial, "a?b?? c");
    EXPECT_EQ(read.part_type, "");
}

TEST(RegisterMap, SequenceNumbersDifferFromTheLastAndFromTheEcho) {
    EXPECT_EQ(sequence_of(1, 0), 1);
    EXPECT_EQ(sequence_of(65'535, 0), 65'535);
    EXPECT_EQ(sequence_of(65'536, 0), 1);
    EXPECT_EQ(sequence_of(1, 1), 2);
    EXPECT_EQ(sequence_of(65'535, 65'535), 1);
    uint16_t last = 0;
    for (DefectId id = 1; id < 200'000; ++id) {
        const uint16_t sequence = sequence_of(id, last);
        ASSERT_NE(sequence, 0);
        ASSERT_NE(sequence, last) << id;
        last = sequence;
    }
}

TEST(RegisterMap, TheSheetNamesEveryRegisterAndBit) {
    const std::string markdown = register_map_markdown(), csv = register_map_csv();
    for (const RegisterLine& line : register_map) {
        EXPECT_THAT(markdown, HasSubstr(std::string("`") + line.name + "`"));
        EXPECT_THAT(csv, HasSubstr(std::string(",") + line.name + ","));
    }
    for (const StatusBitLine& line : status_bits) EXPECT_THAT(markdown, HasSubstr(line.meaning));
    EXPECT_THAT(markdown, HasSubstr("write that number into `echo_sequence`"));
    EXPECT_THAT(markdown, HasSubstr("`part_sequence_taken` shows that number"));
    EXPECT_THAT(markdown, HasSubstr("| 9-10 | int32 | `defect_x` | mm | position in the frame"));
    EXPECT_THAT(csv, HasSubstr("to PLC,9,2,int32,defect_x,mm,\"position in the frame"));
}

}  // namespace
}  // namespace deixis
