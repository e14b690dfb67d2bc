// One poll loop over non-blocking sockets; libmodbus builds and sends the answers to requests judged before.
#include "appliance/plc/modbus_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "appliance/plc/address_list.h"
#include "appliance/plc/modbus_request.h"

namespace deixis {
namespace {

using Clock = LinkBoard::Clock;
using std::chrono::milliseconds;

struct MappingDeleter {
    void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
};
struct ServerContextDeleter {
    void operator()(modbus_t* context) const { modbus_free(context); }
};

struct Client {
    int socket = -1;
    std::string peer;  ///< "127.0.0.1:50000"
    std::array<uint8_t, longest_request> bytes{};
    size_t size = 0;
    Clock::time_point begun;  ///< arrival of the first byte of an unfinished request
    Clock::time_point last_heard;
};

}  // namespace

class ModbusServer::Sockets {
  public:
    Sockets(const PlcParams& params, AddressList allowed, LinkBoard& board, int listener, int port)
        : params_(params),
          allowed_(std::move(allowed)),
          board_(board),
          listener_(listener),
          port_(port),
          context_(modbus_new_tcp("127.0.0.1", port)),
          mapping_(modbus_mapping_new(0, 0, from_plc_registers, to_plc_registers)) {}

    ~Sockets() {
        for (const Client& client : clients_) ::close(client.socket);
        ::close(listener_);
    }
    Sockets(const Sockets&) = delete;
    Sockets& operator=(const Sockets&) = delete;

    int port() const { return port_; }

    void serve(int stop_event) {
        tell_connections();
        for (;;) {
            polled_.clear();
            polled_.push_back({stop_event, POLLIN, 0});
            const bool accepting = Clock::now() >= accept_again_at_;
            polled_.push_back({accepting ? listener_ : -1, POLLIN, 0});
            for (const Client& client : clients_) polled_.push_back({client.socket, POLLIN, 0});
            ::poll(polled_.data(), polled_.size(), clients_.empty() && accepting ? 1'000 : 50);
            if (polled_[0].revents != 0) return;
            const size_t before = clients_.size();
            for (size_t i = 0; i < clients_.size(); ++i)
                if (polled_[2 + i].revents != 0) hear(clients_[i]);
            if (polled_[1].revents != 0) accept_one();
            close_overdue();
            std::erase_if(clients_, [](const Client& client) { return client.socket < 0; });
            if (clients_.size() != before || polled_[1].revents != 0) tell_connections();
        }
    }

  private:
    void tell_connections() {
        board_.set_connections(static_cast<int>(clients_.size()),
                               "no PLC is connected to " + params_.address + ":" + std::to_string(port_) +
                                   "; check the PLC, its cable and the setting plc.allowed");
    }

    void accept_one() {
        sockaddr_in address{};
        socklen_t length = sizeof address;
        const int socket = ::accept4(listener_, reinterpret_cast<sockaddr*>(&address), &length,
                                     SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (socket < 0) {
            if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED)
                board_.refuse(std::string("PLC link: cannot accept a connection: ") + std::strerror(errno));
            if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS)
                accept_again_at_ = Clock::now() + milliseconds(200);
            return;
        }
        const uint32_t from = ntohl(address.sin_addr.s_addr);
        const std::string peer = ipv4_text(from) + ":" + std::to_string(ntohs(address.sin_port));
        std::string why_not;
        if (!allowed_.allows(from))
            why_not = "its address is not in plc.allowed";
        else if (clients_.size() >= static_cast<size_t>(params_.max_connections))
            why_not = std::to_string(clients_.size()) + " are open already (plc.max_connections)";
        if (!why_not.empty()) {
            ::close(socket);
            board_.refuse("PLC link: closed the connection from " + peer + ": " + why_not);
            return;
        }
        const int on = 1;
        ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        ::setsockopt(socket, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
        Client client;
        client.socket = socket;
        client.peer = peer;
        client.last_heard = Clock::now();
        clients_.push_back(client);
    }

    void hear(Client& client) {
        const ssize_t got =
            ::recv(client.socket, client.bytes.data() + client.size, client.bytes.size() - client.size, 0);
        if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
        if (got <= 0) {
            if (client.size > 0)
                refuse_and_close(client, "the connection ended after " + std::to_string(client.size) +
                                             " bytes of a request");
            else
                close(client);
            return;
        }
        const Clock::time_point now = Clock::now();
        if (client.size == 0) client.begun = now;
        client.last_heard = now;
        client.size += static_cast<size_t>(got);
        while (client.socket >= 0 && client.size > 0 && serve_front(client)) {
        }
    }

    /// Answers the request at the front; false when it is not complete.
    bool serve_front(Client& client) {
        const RequestVerdict verdict = judge_request(client.bytes.data(), client.size);
        if (verdict.kind == RequestVerdict::Kind::incomplete) return false;
        if (verdict.kind == RequestVerdict::Kind::close) {
            refuse_and_close(client, verdict.sentence);
            return false;
        }
        answer(client, verdict);
        if (client.socket < 0) return false;
        std::copy(client.bytes.begin() + verdict.length, client.bytes.begin() + client.size,
                  client.bytes.begin());
        client.size -= verdict.length;
        client.begun = Clock::now();
        return true;
    }

    void answer(Client& client, const RequestVerdict& verdict) {
        modbus_set_socket(context_.get(), client.socket);
        int sent = 0;
        if (verdict.kind == RequestVerdict::Kind::except) {
            sent = modbus_reply_exception(context_.get(), client.bytes.data(),
                                          static_cast<unsigned>(verdict.exception));
            board_.refuse("PLC link: refused a request from " + client.peer + " with exception " +
                          std::to_string(verdict.exception) + ": " + verdict.sentence);
        } else {
            const ToPlcWords words = board_.words_for_plc();
            std::copy(words.begin(), words.end(), mapping_->tab_input_registers);
            sent = modbus_reply(context_.get(), client.bytes.data(), static_cast<int>(verdict.length),
                                mapping_.get());
            board_.count_request();
            if (verdict.writes) {
                FromPlcWords said{};
                std::copy_n(mapping_->tab_registers, said.size(), said.begin());
                board_.read_from_plc(said);
            }
        }
        if (sent < 0) refuse_and_close(client, "it does not read its answers");
    }

    void close_overdue() {
        const Clock::time_point now = Clock::now();
        for (Client& client : clients_) {
            if (client.socket < 0) continue;
            if (client.size > 0 && now - client.begun > milliseconds(params_.request_timeout_ms))
                refuse_and_close(client, "a request was not complete after " +
                                             std::to_string(params_.request_timeout_ms) + " ms (" +
                                             std::to_string(client.size) + " bytes came)");
            else if (now - client.last_heard > milliseconds(params_.idle_timeout_ms))
                refuse_and_close(client,
                                 "it asked nothing for " + std::to_string(params_.idle_timeout_ms) + " ms");
        }
    }

    void refuse_and_close(Client& client, const std::string& why) {
        board_.refuse("PLC link: closed the connection from " + client.peer + ": " + why);
        close(client);
    }

    static void close(Client& client) {
        ::close(client.socket);
        client.socket = -1;
    }

    const PlcParams params_;
    const AddressList allowed_;
    LinkBoard& board_;
    const int listener_;
    const int port_;
    std::unique_ptr<modbus_t, ServerContextDeleter> context_;
    std::unique_ptr<modbus_mapping_t, MappingDeleter> mapping_;
    std::vector<Client> clients_;
    std::vector<pollfd> polled_;
    Clock::time_point accept_again_at_;
};

Result<std::unique_ptr<ModbusServer>> ModbusServer::listen(const PlcParams& params, LinkBoard& board) {
    auto allowed = AddressList::read(params.allowed);
    if (!allowed) return fail("the setting plc.allowed: " + allowed.error().sentence);
    const auto own = ipv4_of(params.address);
    if (!own) return fail("the setting plc.address is \"" + params.address + "\"; expected an IPv4 address");
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const int on = 1;
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(params.port));
    address.sin_addr.s_addr = htonl(*own);
    socklen_t length = sizeof address;
    if (listener < 0 || ::setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
        ::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(listener, 16) != 0 ||
        ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
        const std::string why = std::strerror(errno);
        if (listener >= 0) ::close(listener);
        return fail("the PLC link cannot listen on " + params.address + ":" + std::to_string(params.port) +
                    ": " + why +
                    "; choose another plc.address or plc.port, or end the program that holds it");
    }
    return std::unique_ptr<ModbusServer>(new ModbusServer(
        std::make_unique<Sockets>(params, std::move(*allowed), board, listener, ntohs(address.sin_port))));
}

ModbusServer::ModbusServer(std::unique_ptr<Sockets> sockets) : sockets_(std::move(sockets)) {}
ModbusServer::~ModbusServer() = default;
int ModbusServer::port() const {
    return sockets_->port();
}
void ModbusServer::serve(int stop_event) {
    sockets_->serve(stop_event);
}

}  // namespace deixis
