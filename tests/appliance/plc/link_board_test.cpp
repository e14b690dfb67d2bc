// The rules between station and PLC: one defect at a time, echo, part hand-over, heartbeats, bounds.
#include "appliance/plc/link_board.h"

#include <gmock/gmock.h>

namespace deixis {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int sequence_register = 6, id_register = 8, waiting_register = 5, taken_register = 3;

PlcDefect defect(DefectId id) {
    PlcDefect made;
    made.id = id;
    return made;
}

FromPlcWords plc_says(uint16_t echo, uint16_t heartbeat = 0, uint16_t part = 0,
                      const std::string& serial = "") {
    PlcInputs inputs;
    inputs.echo_sequence = echo;
    inputs.heartbeat = heartbeat;
    inputs.part_sequence = part;
    inputs.part_type = "bumper";
    inputs.part_serial = serial;
    return to_words(inputs);
}

TEST(LinkBoard, ShowsOneDefectAfterTheOtherAsThePlcEchoes) {
    LinkBoard board({});
    board.read_from_plc(plc_says(0));
    for (DefectId id = 1; id <= 3; ++id) ASSERT_TRUE(board.deliver(defect(id)));
    for (uint16_t id = 1; id <= 3; ++id) {
        const ToPlcWords words = board.words_for_plc();
        EXPECT_EQ(words[sequence_register], id);
        EXPECT_EQ(words[id_register], id);
        EXPECT_EQ(words[waiting_register], 4 - id);
        board.read_from_plc(plc_says(static_cast<uint16_t>(id + 50)));  // another number is no echo
        EXPECT_EQ(board.words_for_plc()[sequence_register], id);
        board.read_from_plc(plc_says(id));
        EXPECT_THAT(board.take_echoed(), ElementsAre(id));
    }
    EXPECT_EQ(board.words_for_plc()[sequence_register], 0);
    EXPECT_EQ(board.state().defects_echoed, 3U);
    EXPECT_THAT(board.take_echoed(), IsEmpty());
}

TEST(LinkBoard, AnEchoLeftFromAnEarlierRecordIsNoEcho) {
    LinkBoard board({});
    ASSERT_TRUE(board.deliver(defect(1)));
    board.read_from_plc(plc_says(1));
    EXPECT_THAT(board.take_echoed(), IsEmpty());
    EXPECT_EQ(board.words_for_plc()[sequence_register], 2) << "a number that the PLC notices";
    board.read_from_plc(plc_says(2));
    EXPECT_THAT(board.take_echoed(), ElementsAre(1));
    ASSERT_TRUE(board.deliver(defect(2)));
    EXPECT_EQ(board.words_for_plc()[sequence_register], 3);
}

TEST(LinkBoard, RefusesWhatDoesNotFitIntoTheQueueAndTakesNothingTwice) {
    PlcParams params;
    params.queue_length = 2;
    LinkBoard board(params);
    for (const DefectId id : {1, 1, 2, 2}) EXPECT_TRUE(board.deliver(defect(id)));
    const auto third = board.deliver(defect(3));
    ASSERT_FALSE(third);
    EXPECT_EQ(third.error().sentence,
              "defect 3 is not queued for the PLC: 2 already wait for its echo; the record keeps it as "
              "undelivered");
    EXPECT_EQ(board.state().defects_waiting, 2);
}

TEST(LinkBoard, TakesAPartOnlyWithANewPartSequence) {
    LinkBoard board({});
    board.read_from_plc(plc_says(0, 0, 0, "half written"));
    EXPECT_EQ(board.inputs().part_serial, "");
    board.read_from_plc(plc_says(0, 0, 5, "A"));
    EXPECT_EQ(board.inputs().part_serial, "A");
    EXPECT_EQ(board.words_for_plc()[taken_register], 0) << "the station has not taken it";
    PlcOutputs outputs;
    outputs.part_sequence_taken = board.inputs().part_sequence;
    board.publish(outputs);
    EXPECT_EQ(board.words_for_plc()[taken_register], 5);
    board.read_from_plc(plc_says(0, 0, 5, "B"));
    EXPECT_EQ(board.inputs().part_serial, "A") << "the PLC has not finished writing";
    board.read_from_plc(plc_says(0, 0, 6, "B"));
    EXPECT_EQ(board.inputs().part_serial, "B");
    board.read_from_plc(plc_says(0, 0, 0, "B"));
    EXPECT_EQ(board.inputs().part_serial, "") << "the part has left";
}

TEST(LinkBoard, KnowsALivingPlcByItsHeartbeat) {
    LinkBoard board({});
    board.set_connections(0, "nobody there");
    EXPECT_EQ(board.state().phase, LinkPhase::waiting);
    EXPECT_EQ(board.state().reason, "nobody there");
    board.set_connections(1, "");
    board.read_from_plc(plc_says(0, 7));
    EXPECT_EQ(board.state().phase, LinkPhase::connected) << "a first value is no beat";
    EXPECT_THAT(board.state().reason, HasSubstr("heartbeat stands still"));
    board.read_from_plc(plc_says(0, 8));
    EXPECT_EQ(board.state().phase, LinkPhase::alive);
    EXPECT_EQ(board.state().reason, "");
    board.set_connections(0, "gone");
    board.set_connections(1, "");
    EXPECT_EQ(board.state().phase, LinkPhase::connected) << "beats do not outlive their connection";
}

TEST(LinkBoard, TheStatusWordIsEmptyUntilTheStationPublishes) {
    LinkBoard board({});
    EXPECT_EQ(board.words_for_plc()[0], 0);
    PlcOutputs outputs;
    outputs.ready = true;
    board.publish(outputs);
    board.publish(outputs);
    EXPECT_EQ(board.words_for_plc()[0], 1);
    EXPECT_EQ(board.words_for_plc()[1], 2) << "one heartbeat a publish";
}

TEST(LinkBoard, KeepsTheNewestSentencesOnly) {
    LinkBoard board({});
    for (int n = 0; n < 1'000; ++n) board.refuse(std::to_string(n));
    const auto log = board.take_log();
    ASSERT_EQ(log.size(), 200U);
    EXPECT_EQ(log.front(), "800");
    EXPECT_EQ(log.back(), "999");
    EXPECT_THAT(board.take_log(), IsEmpty());
    EXPECT_EQ(board.state().refused, 1'000U);
}

TEST(PlcParams, NamesEveryBadSetting) {
    const auto complaint = [](void (*spoil)(PlcParams&)) {
        PlcParams params;
        params.mode = "server";
        spoil(params);
        const auto link = PlcLink::start(params);
        return link ? std::string("started") : link.error().sentence;
    };
    EXPECT_EQ(complaint([](PlcParams& p) { p.mode = "both"; }),
              "the setting plc.mode is \"both\"; expected \"off\", \"server\" or \"client\"");
    EXPECT_EQ(complaint([](PlcParams& p) { p.address = "plc"; }),
              "the setting plc.address is \"plc\"; expected an IPv4 address as 192.168.3.7");
    EXPECT_EQ(complaint([](PlcParams& p) { p.address = "0.0.0.0"; }),
              "the setting plc.address is \"0.0.0.0\"; expected the address of one interface, by name");
    EXPECT_EQ(complaint([](PlcParams& p) { p.allowed = "anyone"; }),
              "the setting plc.allowed is \"anyone\"; expected IPv4 addresses or networks, by comma");
    EXPECT_THAT(complaint([](PlcParams& p) { p.port = 65'536; }), HasSubstr("plc.port is \"65536"));
    EXPECT_THAT(complaint([](PlcParams& p) { p.max_connections = 0; }),
                HasSubstr("plc.max_connections is \"0"));
    EXPECT_THAT(complaint([](PlcParams& p) { p.request_timeout_ms = 0; }),
                HasSubstr("plc.request_timeout_ms"));
    EXPECT_THAT(complaint([](PlcParams& p) { p.unit = 256; }), HasSubstr("plc.unit is \"256"));
    EXPECT_THAT(complaint([](PlcParams& p) { p.to_plc_address = 35; }), HasSubstr("does not overlap"));
    EXPECT_THAT(complaint([](PlcParams& p) { p.from_plc_address = 65'501; }),
                HasSubstr("plc.from_plc_address"));
    EXPECT_THAT(complaint([](PlcParams& p) { p.queue_length = 0; }), HasSubstr("plc.queue_length"));
    EXPECT_THAT(complaint([](PlcParams& p) { p.reconnect_longest_ms = 5; }),
                HasSubstr("plc.reconnect_longest_ms"));
}

TEST(PlcLink, OffTalksToNobody) {
    const auto link = PlcLink::start({}).value();
    link->publish({});
    EXPECT_TRUE(link->deliver(defect(1)));
    EXPECT_EQ(link->state().phase, LinkPhase::off);
    EXPECT_EQ(link->port(), 0);
}

}  // namespace
}  // namespace deixis
