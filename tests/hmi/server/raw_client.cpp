// Plain sockets for the tests of the screen server.
#include "tests/hmi/server/raw_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace deixis {
namespace {

constexpr int patience_ms = 10000;

}  // namespace

std::string RawAnswer::header(const std::string& name) const {
    const size_t at = head.find("\r\n" + name + ": ");
    if (at == std::string::npos) return {};
    const size_t begin = at + 4 + name.size();
    return head.substr(begin, head.find("\r\n", begin) - begin);
}

int RawFrame::close_code() const {
    return payload.size() < 2 ? 0 : static_cast<uint8_t>(payload[0]) * 256 + static_cast<uint8_t>(payload[1]);
}

std::string RawFrame::close_reason() const {
    return payload.size() < 2 ? "" : payload.substr(2);
}

RawClient::RawClient(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        throw std::runtime_error("no connection to port " + std::to_string(port));
}

RawClient::~RawClient() {
    if (socket_ >= 0) ::close(socket_);
}

bool RawClient::send(std::string_view bytes) {
    while (!bytes.empty()) {
        const auto sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent <= 0) return false;
        bytes.remove_prefix(static_cast<size_t>(sent));
    }
    return true;
}

bool RawClient::fill() {
    pollfd polled{socket_, POLLIN, 0};
    if (::poll(&polled, 1, patience_ms) != 1) return false;
    std::array<char, 65536> buffer;
    const auto got = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (got <= 0) return false;
    inbox_.append(buffer.data(), static_cast<size_t>(got));
    return true;
}

std::optional<std::string> RawClient::read_to_end() {
    while (fill()) {
    }
    pollfd polled{socket_, POLLIN, 0};
    if (::poll(&polled, 1, 0) != 1) return std::nullopt;  // the deadline, not the end
    return std::move(inbox_);
}

RawAnswer RawClient::answer() {
    RawAnswer answer;
    const auto all = read_to_end();
    const size_t end = all ? all->find("\r\n\r\n") : std::string::npos;
    if (end == std::string::npos || all->rfind("HTTP/1.1 ", 0) != 0) return answer;
    answer.status = std::stoi(all->substr(9, 3));
    answer.head = all->substr(0, end + 2);
    answer.body = all->substr(end + 4);
    return answer;
}

bool RawClient::upgraded() {
    while (inbox_.find("\r\n\r\n") == std::string::npos)
        if (!fill()) return false;
    const bool yes = inbox_.rfind("HTTP/1.1 101 ", 0) == 0;
    inbox_.erase(0, inbox_.find("\r\n\r\n") + 4);
    return yes;
}

std::optional<RawFrame> RawClient::frame() {
    const auto have = [this](size_t count) {
        while (inbox_.size() < count)
            if (!fill()) return false;
        return true;
    };
    if (!have(2)) return std::nullopt;
    const auto byte = [this](size_t i) { return static_cast<uint8_t>(inbox_[i]); };
    RawFrame frame{byte(0) & 0x0F, {}};
    size_t size = byte(1) & 0x7F;
    size_t begin = 2;
    if (size >= 126) {
        const size_t length_bytes = size == 126 ? 2 : 8;
        if (!have(2 + length_bytes)) return std::nullopt;
        size = 0;
        for (size_t i = 0; i < length_bytes; ++i) size = size * 256 + byte(2 + i);
        begin = 2 + length_bytes;
    }
    if (!have(begin + size)) return std::nullopt;
    frame.payload = inbox_.substr(begin, size);
    inbox_.erase(0, begin + size);
    return frame;
}

void RawClient::abort() {
    const linger at_once{1, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    ::close(socket_);
    socket_ = -1;
}

void RawClient::keep_little() {
    const int bytes = 4096;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

std::string get_request(const std::string& path, const std::string& more_headers) {
    return "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:8765\r\n" + more_headers + "\r\n";
}

std::string live_request() {
    return get_request(
        "/api/live",
        "Connection: keep-alive, Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nOrigin: http://127.0.0.1:8765\r\n");
}

std::string client_frame(int first_byte, std::string_view payload) {
    const std::string mask = "\x11\x22\x33\x44";
    std::string frame;
    frame += static_cast<char>(first_byte);
    frame += static_cast<char>(0x80 | payload.size());
    frame += mask;
    for (size_t i = 0; i < payload.size(); ++i) frame += static_cast<char>(payload[i] ^ mask[i % 4]);
    return frame;
}

}  // namespace deixis
