// Frames of the WebSocket, written and read.
#include "hmi/server/web_socket_frames.h"

#include <Poco/Base64Encoder.h>
#include <Poco/SHA1Engine.h>

#include <algorithm>
#include <cctype>
#include <sstream>

namespace deixis {
namespace {

tl::unexpected<WebSocketRefusal> refuse_frame(uint16_t code, std::string sentence) {
    return tl::unexpected<WebSocketRefusal>(WebSocketRefusal{code, std::move(sentence)});
}

}  // namespace

std::string web_socket_accept(std::string_view key) {
    Poco::SHA1Engine digest;
    digest.update(key.data(), key.size());
    digest.update(std::string("258EAFA5-E914-47DA-95CA-C5AB0DC85B11"));
    std::ostringstream text;
    Poco::Base64Encoder encoder(text);
    for (const unsigned char byte : digest.digest()) encoder << static_cast<char>(byte);
    encoder.close();
    return text.str();
}

bool is_web_socket_key(std::string_view key) {
    return key.size() == 24 && key.substr(22) == "==" &&
           std::all_of(key.begin(), key.begin() + 22, [](unsigned char c) {
               return c < 0x80 && (std::isalnum(c) != 0 || c == '+' || c == '/');
           });
}

std::string encode_web_socket_frame(WebSocketOpcode opcode, std::string_view payload) {
    std::string frame;
    frame.reserve(payload.size() + 10);
    frame += static_cast<char>(0x80 | static_cast<uint8_t>(opcode));
    const uint64_t size = payload.size();
    const int length_bytes = size < 126 ? 0 : size < 65536 ? 2 : 8;
    frame += static_cast<char>(length_bytes == 0 ? size : length_bytes == 2 ? 126 : 127);
    for (int i = length_bytes - 1; i >= 0; --i) frame += static_cast<char>(size >> (8 * i) & 0xFF);
    return frame.append(payload);
}

std::string encode_web_socket_close(uint16_t code, std::string_view reason) {
    std::string payload = {static_cast<char>(code >> 8), static_cast<char>(code & 0xFF)};
    return encode_web_socket_frame(WebSocketOpcode::close, payload.append(reason.substr(0, 123)));
}

tl::expected<std::optional<ClientFrame>, WebSocketRefusal> read_client_frame(std::string_view arrived) {
    if (arrived.size() < 2) return std::nullopt;
    const auto first = static_cast<uint8_t>(arrived[0]);
    const auto second = static_cast<uint8_t>(arrived[1]);
    if ((first & 0x70) != 0) return refuse_frame(1002, "A frame sets a reserved bit.");
    const int opcode = first & 0x0F;
    if (opcode <= 2) return refuse_frame(1003, "The live stream takes no messages from clients.");
    if (opcode < 8 || opcode > 10) return refuse_frame(1002, "A frame has a reserved opcode.");
    if ((second & 0x80) == 0) return refuse_frame(1002, "A client frame is not masked.");
    if ((first & 0x80) == 0) return refuse_frame(1002, "A control frame is fragmented.");
    const size_t size = second & 0x7F;
    if (size > 125) return refuse_frame(1002, "A control frame is longer than 125 bytes.");
    if (opcode == 8 && size == 1) return refuse_frame(1002, "A close frame has a body of one byte.");
    if (arrived.size() < 6 + size) return std::nullopt;
    ClientFrame frame{static_cast<WebSocketOpcode>(opcode), std::string(arrived.substr(6, size)), 6 + size};
    for (size_t i = 0; i < size; ++i)
        frame.payload[i] = static_cast<char>(frame.payload[i] ^ arrived[2 + i % 4]);
    return frame;
}

}  // namespace deixis
