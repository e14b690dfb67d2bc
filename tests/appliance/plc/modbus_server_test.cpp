// The station as Modbus server: against raw bytes, against mbpoll, against a pymodbus PLC.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "appliance/plc/plc_link.h"
#include "tests/appliance/plc/child_program.h"
#include "tests/appliance/plc/modbus_bytes.h"

namespace deixis {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

PlcParams server_params() {
    PlcParams params;
    params.mode = "server";
    params.port = 0;
    return params;
}

std::unique_ptr<PlcLink> serve(const PlcParams& params = server_params()) {
    auto link = PlcLink::start(params);
    EXPECT_TRUE(link) << link.error().sentence;
    return std::move(*link);
}

/// A connection that says exactly the bytes it is told to.
class RawClient {
  public:
    explicit RawClient(int port, const char* from = nullptr) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        if (from != nullptr) {
            const sockaddr_in own = at(from, 0);
            EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
        }
        const sockaddr_in peer = at("127.0.0.1", port);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&peer), sizeof peer), 0);
    }
    ~RawClient() { ::close(socket_); }
    RawClient(const RawClient&) = delete;
    RawClient& operator=(const RawClient&) = delete;

    void say(const Bytes& bytes) const { ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

    /// The next answer of exactly `size` bytes; shorter when the connection ends, empty after 20 s of
    /// silence.
    Bytes hear(size_t size) const {
        Bytes bytes(size);
        size_t have = 0;
        while (have < size) {
            pollfd readable{socket_, POLLIN, 0};
            if (::poll(&readable, 1, 20'000) <= 0) return {};
            const ssize_t got = ::recv(socket_, bytes.data() + have, size - have, 0);
            if (got <= 0) break;
            have += static_cast<size_t>(got);
        }
        bytes.resize(have);
        return bytes;
    }

    /// True when the server has closed the connection and said nothing before.
    bool closed() const {
        pollfd readable{socket_, POLLIN, 0};
        if (::poll(&readable, 1, 20'000) <= 0) return false;
        char byte = 0;
        return ::recv(socket_, &byte, 1, 0) <= 0;
    }

  private:
    static sockaddr_in at(const char* ip, int port) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<uint16_t>(port));
        ::inet_pton(AF_INET, ip, &address.sin_addr);
        return address;
    }
    int socket_;
};

/// Waits until the link has logged something and returns it.
std::vector<std::string> next_log(PlcLink& link) {
    std::vector<std::string> log;
    EXPECT_TRUE(eventually([&] {
        log = link.take_log();
        return !log.empty();
    }));
    return log;
}

PlcDefect sample_defect(DefectId id) {
    PlcDefect defect;
    defect.id = id;
    defect.position = {0.31, -0.02, 0.12 + 0.001 * static_cast<double>(id)};
    defect.zone_number = 2;
    defect.arm = ArmSide::left;
    defect.part_serial = "SN-0042";
    return defect;
}

TEST(ModbusServer, AnswersEveryBadRequestWithItsExceptionOrCloses) {
    const auto link = serve();
    for (const BadRequest& bad : bad_requests()) {
        const RawClient client(link->port());
        client.say(bad.bytes);
        if (bad.exception == 0) {
            EXPECT_TRUE(client.closed()) << bad.sentence;
            EXPECT_THAT(next_log(*link),
                        Contains(AllOf(StartsWith("PLC link: closed the connection from 127.0.0.1:"),
                                       EndsWith(bad.sentence))));
        } else {
            const Bytes expected{0x12,
                                 0x34,
                                 0,
                                 0,
                                 0,
                                 3,
                                 1,
                                 static_cast<uint8_t>(bad.bytes[7] | 0x80),
                                 static_cast<uint8_t>(bad.exception)};
            EXPECT_EQ(client.hear(9), expected) << bad.sentence;
            EXPECT_THAT(next_log(*link),
                        Contains(AllOf(StartsWith("PLC link: refused a request from 127.0.0.1:"),
                                       HasSubstr("with exception " + std::to_string(bad.exception) + ": "),
                                       HasSubstr(bad.sentence))));
            client.say(request(pdu(3, {0, 1})));  // a refused request costs a PLC nothing else
            EXPECT_EQ(client.hear(11).size(), 11U) << bad.sentence;
        }
    }
    EXPECT_EQ(link->state().refused, bad_requests().size());
}

TEST(ModbusServer, ABadWriteChangesNothing) {
    const auto link = serve();
    const RawClient client(link->port());
    client.say(request(write_pdu(0, {1, 2, 3})));
    EXPECT_EQ(client.hear(12).size(), 12U);
    client.say(request(write_pdu(34, {9, 9, 9})));
    EXPECT_EQ(client.hear(9).size(), 9U);
    client.say(request(pdu(3, {0, 36})));
    const Bytes answer = client.hear(9 + 72);
    ASSERT_EQ(answer.size(), 81U);
    EXPECT_EQ(Bytes(answer.begin() + 9, answer.begin() + 15), (Bytes{0, 1, 0, 2, 0, 3}));
    EXPECT_EQ(Bytes(answer.begin() + 15, answer.end()), Bytes(66, 0));
}

TEST(ModbusServer, TakesRequestsInPiecesAndSeveralAtOnce) {
    const auto link = serve();
    const RawClient client(link->port());
    for (const uint8_t byte : request(pdu(4, {0, 3}))) client.say({byte});
    EXPECT_EQ(client.hear(15).size(), 15U);
    Bytes several;
    for (int n = 0; n < 20; ++n)
        for (const uint8_t byte : request(pdu(4, {2, 1}))) several.push_back(byte);
    client.say(several);
    for (int n = 0; n < 20; ++n) EXPECT_EQ(client.hear(11), (Bytes{0x12, 0x34, 0, 0, 0, 5, 1, 4, 2, 0, 1}));
}

TEST(ModbusServer, ASlowClientHoldsUpNobodyAndIsClosed) {
    PlcParams params = server_params();
    params.request_timeout_ms = 50;
    const auto link = serve(params);
    const RawClient slow(link->port()), quick(link->port());
    slow.say({0x12, 0x34, 0, 0, 0});
    for (int n = 0; n < 50; ++n) {
        quick.say(request(pdu(4, {0, 1})));
        ASSERT_EQ(quick.hear(11).size(), 11U);
    }
    EXPECT_TRUE(slow.closed());
    EXPECT_THAT(next_log(*link), Contains(EndsWith("a request was not complete after 50 ms (5 bytes came)")));
    quick.say(request(pdu(4, {0, 1})));
    EXPECT_EQ(quick.hear(11).size(), 11U);
}

TEST(ModbusServer, AClientThatDripsIsClosedAllTheSame) {
    PlcParams params = server_params();
    params.request_timeout_ms = 100;
    const auto link = serve(params);
    const RawClient drip(link->port());
    // One byte of the longest request at a time: it could go on for ever if each byte bought more time.
    EXPECT_TRUE(eventually([&] {
        drip.say({0});
        return link->state().refused > 0;
    }));
}

TEST(ModbusServer, AClientThatNeverReadsIsClosed) {
    const auto link = serve();
    const RawClient deaf(link->port()), other(link->port());
    Bytes many;
    for (int n = 0; n < 200; ++n)
        for (const uint8_t byte : request(pdu(4, {0, 34}))) many.push_back(byte);
    std::vector<std::string> log;
    std::thread talker([&] {
        for (int n = 0; n < 2'000 && link->state().refused == 0; ++n) deaf.say(many);
    });
    EXPECT_TRUE(eventually([&] { return link->state().refused > 0; }));
    other.say(request(pdu(4, {0, 1})));
    EXPECT_EQ(other.hear(11).size(), 11U);
    talker.join();
    EXPECT_THAT(link->take_log(), Contains(EndsWith("it does not read its answers")));
}

TEST(ModbusServer, TakesNoMoreConnectionsThanItMay) {
    PlcParams params = server_params();
    params.max_connections = 2;
    const auto link = serve(params);
    const RawClient first(link->port());
    auto second = std::make_unique<RawClient>(link->port());
    EXPECT_TRUE(eventually([&] { return link->state().connections == 2; }));
    EXPECT_TRUE(RawClient(link->port()).closed());
    EXPECT_THAT(next_log(*link), Contains(EndsWith("2 are open already (plc.max_connections)")));
    second.reset();
    EXPECT_TRUE(eventually([&] { return link->state().connections == 1; }));
    const RawClient fourth(link->port());
    fourth.say(request(pdu(4, {0, 1})));
    EXPECT_EQ(fourth.hear(11).size(), 11U);
}

TEST(ModbusServer, ClosesWhoIsNotInTheList) {
    const auto link = serve();
    EXPECT_TRUE(RawClient(link->port(), "127.0.0.2").closed());
    EXPECT_THAT(next_log(*link), Contains(AllOf(StartsWith("PLC link: closed the connection from 127.0.0.2:"),
                                                EndsWith("its address is not in plc.allowed"))));
    PlcParams params = server_params();
    params.allowed = "127.0.0.0/30";
    const auto wider = serve(params);
    const RawClient client(wider->port(), "127.0.0.2");
    client.say(request(pdu(4, {0, 1})));
    EXPECT_EQ(client.hear(11).size(), 11U);
}

TEST(ModbusServer, LogsAConnectionThatEndsInMidRequest) {
    const auto link = serve();
    { RawClient(link->port()).say({0x12, 0x34, 0, 0}); }
    EXPECT_THAT(next_log(*link), Contains(EndsWith("the connection ended after 4 bytes of a request")));
}

TEST(ModbusServer, RefusesAPortThatIsTaken) {
    const auto link = serve();
    PlcParams params = server_params();
    params.port = link->port();
    const auto second = PlcLink::start(params);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().sentence,
              "the PLC link cannot listen on 127.0.0.1:" + std::to_string(link->port()) +
                  ": Address already in use; choose another plc.address or plc.port, or "
                  "end the program that holds it");
}

TEST(ModbusServer, ListensOnItsOneAddressOnly) {
    const auto link = serve();
    sockaddr_in other{};
    other.sin_family = AF_INET;
    other.sin_port = htons(static_cast<uint16_t>(link->port()));
    ::inet_pton(AF_INET, "127.0.0.2", &other.sin_addr);
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_NE(::connect(socket, reinterpret_cast<const sockaddr*>(&other), sizeof other), 0);
    ::close(socket);
}

std::pair<int, std::string> mbpoll(int port, std::vector<std::string> options,
                                   const std::vector<std::string>& values = {}) {
    std::vector<std::string> arguments{"/usr/bin/mbpoll",    "-m", "tcp", "-p",
                                       std::to_string(port), "-0", "-1"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    arguments.emplace_back("127.0.0.1");
    arguments.insert(arguments.end(), values.begin(), values.end());
    return run_program(arguments);
}

TEST(ModbusServer, MbpollReadsAndWritesWhatTheWiringSheetSays) {
    const auto link = serve();
    PlcOutputs outputs;
    outputs.ready = outputs.sensors_ok = true;
    outputs.defect_count = 3;
    link->publish(outputs);
    ASSERT_TRUE(link->deliver(sample_defect(70'000)));
    const auto [read_code, read] = mbpoll(link->port(), {"-t", "3", "-r", "0", "-c", "16"});
    EXPECT_EQ(read_code, 0) << read;
    EXPECT_THAT(read, HasSubstr("[1]: \t1\n"));  // heartbeat: one publish
    EXPECT_THAT(read, HasSubstr("[2]: \t1\n"));  // version of the sheet
    EXPECT_THAT(read, HasSubstr("[4]: \t3\n"));  // defects of the part
    EXPECT_THAT(read, HasSubstr("[6]: \t4465\n"));
    EXPECT_THAT(read, HasSubstr("[7]: \t1\n"));
    EXPECT_THAT(read, HasSubstr("[8]: \t4464\n"));
    EXPECT_THAT(read, HasSubstr("[10]: \t310\n"));
    const auto [write_code, written] = mbpoll(link->port(), {"-t", "4", "-r", "1"}, {"4465", "9"});
    EXPECT_EQ(write_code, 0) << written;
    // The first word a PLC says is what it remembers; the echo counts from the second on.
    ASSERT_EQ(mbpoll(link->port(), {"-t", "4", "-r", "1"}, {"4466"}).first, 0);
    EXPECT_EQ(link->take_echoed(), std::vector<DefectId>{70'000});
    EXPECT_EQ(link->inputs().part_sequence, 9);
    const auto [beyond_code, beyond] = mbpoll(link->port(), {"-t", "3", "-r", "34", "-c", "1"});
    EXPECT_NE(beyond_code, 0);
    EXPECT_THAT(beyond, HasSubstr("Illegal data address"));
}

TEST(ModbusServer, APymodbusPlcTakesEveryDefectOnce) {
    const auto link = serve();
    PlcOutputs outputs;
    outputs.ready = true;
    for (DefectId id = 1; id <= 5; ++id) ASSERT_TRUE(link->deliver(sample_defect(id)));
    ChildProgram plc(
        {"/usr/bin/python3", PLC_SCRIPTS "/plc_that_asks.py", std::to_string(link->port()), "5"});
    for (int id = 1; id <= 5; ++id) {
        outputs.part_sequence_taken = link->inputs().part_sequence;  // as the station does
        link->publish(outputs);
        EXPECT_EQ(plc.line("DEFECT "), std::to_string(id) + " " + std::to_string(id) + " 310 -20 " +
                                           std::to_string(120 + id) + " 2 1 SN-0042")
            << plc.said();
    }
    EXPECT_TRUE(eventually([&] { return link->state().defects_waiting == 0; }));
    EXPECT_EQ(link->take_echoed(), (std::vector<DefectId>{1, 2, 3, 4, 5}));
    EXPECT_EQ(link->inputs().part_type, "bumper-front-a");
    EXPECT_EQ(link->inputs().part_serial, "SN-0042");
    EXPECT_THAT(plc.line("DONE ").value_or(plc.said()), StartsWith("taken 7 waiting 0"));
    EXPECT_EQ(plc.wait(), 0) << plc.said();
    EXPECT_TRUE(eventually([&] { return link->state().phase == LinkPhase::waiting; }));
    EXPECT_THAT(link->state().reason, StartsWith("no PLC is connected to 127.0.0.1:"));
}

}  // namespace
}  // namespace deixis
