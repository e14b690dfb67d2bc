// The station as Modbus client: against a pymodbus PLC that is late, killed, frozen or short of registers,
// and against peers that answer wrongly, slowly or not at all.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <functional>

#include "appliance/plc/plc_link.h"
#include "tests/appliance/plc/child_program.h"
#include "tests/appliance/plc/modbus_bytes.h"

namespace deixis {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A listening socket on a free loopback port.
int listen_somewhere(int& port) {
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    EXPECT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listener, 16), 0);
    EXPECT_EQ(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &length), 0);
    port = ntohs(address.sin_port);
    return listener;
}

int free_port() {
    int port = 0;
    ::close(listen_somewhere(port));
    return port;
}

PlcParams client_params(int port) {
    PlcParams params;
    params.mode = "client";
    params.port = port;
    params.cycle_ms = 10;
    params.answer_timeout_ms = 200;
    params.reconnect_first_ms = 10;
    params.reconnect_longest_ms = 40;
    return params;
}

std::unique_ptr<PlcLink> connect_to(const PlcParams& params) {
    auto link = PlcLink::start(params);
    EXPECT_TRUE(link) << link.error().sentence;
    return std::move(*link);
}

std::unique_ptr<ChildProgram> start_plc(int port, const std::vector<std::string>& options = {}) {
    std::vector<std::string> arguments{"/usr/bin/python3", PLC_SCRIPTS "/plc_that_answers.py",
                                       std::to_string(port)};
    arguments.insert(arguments.end(), options.begin(), options.end());
    auto plc = std::make_unique<ChildProgram>(arguments);
    EXPECT_TRUE(plc->line("LISTENING")) << plc->said();
    return plc;
}

PlcDefect sample_defect(DefectId id) {
    PlcDefect defect;
    defect.id = id;
    return defect;
}

bool reaches(PlcLink& link, LinkPhase phase) {
    return eventually([&] { return link.state().phase == phase; });
}

TEST(ModbusClient, DeliversDefectsAndReadsThePart) {
    const int port = free_port();
    const auto plc = start_plc(port);
    const auto link = connect_to(client_params(port));
    for (DefectId id = 1; id <= 4; ++id) ASSERT_TRUE(link->deliver(sample_defect(id)));
    for (const char* expected : {"1 1", "2 2", "3 3", "4 4"})
        EXPECT_EQ(plc->line("DEFECT "), expected) << plc->said();
    EXPECT_TRUE(eventually([&] { return link->state().defects_echoed == 4; }));
    EXPECT_EQ(link->take_echoed(), (std::vector<DefectId>{1, 2, 3, 4}));
    EXPECT_TRUE(reaches(*link, LinkPhase::alive));
    EXPECT_EQ(link->inputs().part_serial, "SN-0042");
    EXPECT_EQ(link->inputs().part_type, "bumper-front-a");
}

TEST(ModbusClient, WaitsForALatePlc) {
    const int port = free_port();
    const auto link = connect_to(client_params(port));
    EXPECT_TRUE(eventually([&] { return link->state().refused > 0; }));
    EXPECT_EQ(link->state().phase, LinkPhase::waiting);
    EXPECT_EQ(link->state().reason,
              "cannot reach the PLC at 127.0.0.1:" + std::to_string(port) + ": Connection refused");
    ASSERT_TRUE(link->deliver(sample_defect(1)));
    const auto plc = start_plc(port);
    EXPECT_EQ(plc->line("DEFECT "), "1 1");
    EXPECT_TRUE(reaches(*link, LinkPhase::alive));
    EXPECT_EQ(link->state().refused, 1U) << "the same trouble is told once, not at every try";
}

TEST(ModbusClient, LosesNoDefectWhenThePlcIsKilled) {
    const int port = free_port();
    auto plc = start_plc(port, {"--no-echo"});
    const auto link = connect_to(client_params(port));
    for (DefectId id = 1; id <= 3; ++id) ASSERT_TRUE(link->deliver(sample_defect(id)));
    EXPECT_EQ(plc->line("DEFECT "), "1 1");
    plc.reset();  // kill -9
    EXPECT_TRUE(reaches(*link, LinkPhase::waiting));
    EXPECT_EQ(link->state().defects_waiting, 3);
    EXPECT_TRUE(link->take_echoed().empty());
    plc = start_plc(port);
    for (const char* expected : {"1 1", "2 2", "3 3"})
        EXPECT_EQ(plc->line("DEFECT "), expected) << plc->said();
    EXPECT_TRUE(eventually([&] { return link->state().defects_waiting == 0; }));
    EXPECT_EQ(link->take_echoed(), (std::vector<DefectId>{1, 2, 3}));
}

TEST(ModbusClient, TellsAThawedPlcTheNewestStateOnly) {
    const int port = free_port();
    const auto plc = start_plc(port);
    PlcParams params = client_params(port);
    params.stale_ms = 60'000;
    const auto link = connect_to(params);
    PlcOutputs outputs;
    outputs.ready = true;
    link->publish(outputs);
    EXPECT_EQ(plc->line("STATUS "), "1");
    EXPECT_EQ(plc->line("STATUS "), "257") << "with plc_heard";
    EXPECT_TRUE(reaches(*link, LinkPhase::alive));
    plc->signal(SIGSTOP);
    EXPECT_TRUE(reaches(*link, LinkPhase::waiting));
    EXPECT_THAT(link->state().reason, HasSubstr("no answer within 200 ms"));
    for (int n = 0; n < 1'000; ++n) {
        outputs.ready = n % 2 == 0;
        outputs.part_locked = n % 3 == 0;
        link->publish(outputs);
    }
    outputs = {};
    outputs.database_ok = true;
    link->publish(outputs);
    plc->signal(SIGCONT);
    EXPECT_TRUE(reaches(*link, LinkPhase::alive));
    const auto first = plc->line("STATUS ");
    // 16: database_ok. It may come with 256, plc_heard, or get that in the next cycle.
    EXPECT_TRUE(first == "16" || first == "272") << first.value_or(plc->said());
}

TEST(ModbusClient, NamesRegistersThatThePlcDoesNotHave) {
    const int port = free_port();
    const auto plc = start_plc(port, {"--registers", "50"});
    const auto link = connect_to(client_params(port));
    const std::string sentence = "the PLC at 127.0.0.1:" + std::to_string(port) +
                                 " does not take its registers 100 to 133: it has no such registers; compare "
                                 "with `deixis plc map`";
    EXPECT_TRUE(eventually([&] { return link->state().reason == sentence; })) << link->state().reason;
    EXPECT_THAT(link->take_log(), Contains("PLC link: " + sentence));
}

/// A peer that answers each request with what `answer` makes of it; one connection after the other.
class ScriptedPeer {
  public:
    using Answer = std::function<void(int socket, const Bytes& request)>;
    explicit ScriptedPeer(Answer answer) : answer_(std::move(answer)), listener_(listen_somewhere(port_)) {
        thread_ = std::thread([this] { run(); });
    }
    ~ScriptedPeer() {
        stop_ = true;
        thread_.join();
        ::close(listener_);
    }
    ScriptedPeer(const ScriptedPeer&) = delete;
    ScriptedPeer& operator=(const ScriptedPeer&) = delete;

    int port() const { return port_; }
    int connections() const { return connections_; }
    int most_bytes_of_a_connection() const { return most_bytes_; }

  private:
    static bool readable(int socket) {
        pollfd event{socket, POLLIN, 0};
        return ::poll(&event, 1, 5) > 0;
    }

    void run() {
        while (!stop_) {
            if (!readable(listener_)) continue;
            const int socket = ::accept(listener_, nullptr, nullptr);
            ++connections_;
            int bytes_here = 0;
            while (!stop_) {
                if (!readable(socket)) continue;
                Bytes bytes(512);
                const ssize_t got = ::recv(socket, bytes.data(), bytes.size(), 0);
                if (got <= 0) break;
                bytes_here += static_cast<int>(got);
                most_bytes_ = std::max(most_bytes_.load(), bytes_here);
                bytes.resize(static_cast<size_t>(got));
                answer_(socket, bytes);
            }
            ::close(socket);
        }
    }

    const Answer answer_;
    int port_ = 0;
    const int listener_;
    std::atomic<bool> stop_{false};
    std::atomic<int> connections_{0}, most_bytes_{0};
    std::thread thread_;
};

void say(int socket, const Bytes& bytes) {
    ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

/// The right answer to a reading request for 36 registers.
Bytes right_answer(const Bytes& asked) {
    Bytes answer{asked[0], asked[1], 0, 0, 0, 75, asked[6], 3, 72};
    answer.resize(81);
    return answer;
}

TEST(ModbusClient, ASilentPeerGetsOneRequestAConnectionAndNoFlood) {
    const ScriptedPeer peer([](int, const Bytes&) {});
    PlcParams params = client_params(peer.port());
    params.answer_timeout_ms = 20;
    const auto link = connect_to(params);
    EXPECT_TRUE(eventually([&] {
        link->publish({});
        return peer.connections() >= 5;
    }));
    EXPECT_EQ(peer.most_bytes_of_a_connection(), 12) << "one reading request";
    EXPECT_EQ(link->state().phase, LinkPhase::waiting);
    EXPECT_THAT(link->state().reason, HasSubstr("no answer within 20 ms"));
}

TEST(ModbusClient, APeerThatDripsItsAnswerMissesTheDeadline) {
    const ScriptedPeer peer([](int socket, const Bytes& asked) {
        for (const uint8_t byte : right_answer(asked)) {
            say(socket, {byte});
            pollfd none{-1, 0, 0};
            ::poll(&none, 1, 20);
        }
    });
    PlcParams params = client_params(peer.port());
    params.answer_timeout_ms = 100;  // byte by byte the answer takes 1.6 s
    const auto link = connect_to(params);
    EXPECT_TRUE(eventually([&] { return link->state().refused > 0; }));
    EXPECT_THAT(link->state().reason, HasSubstr("no answer within 100 ms"));
}

TEST(ModbusClient, WrongAnswersAreRefusedInASentenceAndTheNextConnectionIsTried) {
    const struct {
        const char* name;
        std::function<Bytes(const Bytes&)> answer;
    } cases[] = {
        {"another transaction",
         [](const Bytes& asked) {
             Bytes a = right_answer(asked);
             a[1] ^= 1;
             return a;
         }},
        {"another function",
         [](const Bytes& asked) {
             Bytes a = right_answer(asked);
             a[7] = 4;
             return a;
         }},
        {"fewer registers",
         [](const Bytes& asked) {
             Bytes a = right_answer(asked);
             a[8] = 70;
             a[5] = 73;
             a.resize(79);
             return a;
         }},
        {"cut short",
         [](const Bytes& asked) {
             Bytes a = right_answer(asked);
             a.resize(40);
             return a;
         }},
        {"an exception",
         [](const Bytes& asked) { return Bytes{asked[0], asked[1], 0, 0, 0, 3, asked[6], 0x83, 4}; }},
        {"an unknown exception",
         [](const Bytes& asked) { return Bytes{asked[0], asked[1], 0, 0, 0, 3, asked[6], 0x83, 99}; }},
        {"noise", [](const Bytes&) { return Bytes(300, 0xA5); }},
        {"a web page",
         [](const Bytes&) {
             const std::string s = "HTTP/1.1 400 Bad Request\r\n\r\n";
             return Bytes(s.begin(), s.end());
         }},
        {"zeros", [](const Bytes&) { return Bytes(260, 0); }},
    };
    for (const auto& wrong : cases) {
        const ScriptedPeer peer([&](int socket, const Bytes& asked) { say(socket, wrong.answer(asked)); });
        PlcParams params = client_params(peer.port());
        params.answer_timeout_ms = 50;
        const auto link = connect_to(params);
        EXPECT_TRUE(eventually([&] { return peer.connections() >= 2; })) << wrong.name;
        EXPECT_TRUE(eventually([&] { return link->state().phase == LinkPhase::waiting; })) << wrong.name;
        EXPECT_THAT(link->state().reason, AllOf(StartsWith("the PLC at 127.0.0.1:"),
                                                HasSubstr("does not give its registers 0 to 35: ")))
            << wrong.name;
        EXPECT_EQ(link->inputs().part_sequence, 0) << wrong.name;
        EXPECT_EQ(link->state().requests, 0U) << wrong.name;
    }
}

TEST(ModbusClient, APeerThatHangsUpIsTriedAgain) {
    const ScriptedPeer peer([](int socket, const Bytes&) { ::shutdown(socket, SHUT_RDWR); });
    const auto link = connect_to(client_params(peer.port()));
    EXPECT_TRUE(eventually([&] { return peer.connections() >= 3; }));
    EXPECT_EQ(link->state().phase, LinkPhase::waiting);
}

TEST(ModbusClient, EndsAtOnceWhileNobodyAnswers) {
    PlcParams params = client_params(free_port());
    params.reconnect_first_ms = params.reconnect_longest_ms = 60'000;
    const auto link = connect_to(params);
    EXPECT_TRUE(eventually([&] { return link->state().refused > 0; }));
    // The test's own time limit is what this would run into if the destructor waited for the next try.
}

}  // namespace
}  // namespace deixis
