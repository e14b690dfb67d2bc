// WebSocket framing (RFC 6455), server side: frames to send as bytes, and a strict reader of what a client
// sends.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace deixis {

enum class WebSocketOpcode : uint8_t { text = 1, binary = 2, close = 8, ping = 9, pong = 10 };

/// The Sec-WebSocket-Accept value for a client's key.
std::string web_socket_accept(std::string_view key);

/// Whether a Sec-WebSocket-Key is the base64 form of 16 bytes.
bool is_web_socket_key(std::string_view key);

/// One complete unmasked frame.
std::string encode_web_socket_frame(WebSocketOpcode opcode, std::string_view payload);

/// A close frame; `reason` is cut to the 123 bytes that fit.
std::string encode_web_socket_close(uint16_t code, std::string_view reason);

struct WebSocketRefusal {
    uint16_t code = 1002;
    std::string sentence;  ///< the close reason
};

struct ClientFrame {
    WebSocketOpcode opcode = WebSocketOpcode::ping;
    std::string payload;
    size_t bytes = 0;  ///< how much of the input it took
};

/// The first frame in `arrived`; nothing while it is incomplete. The live stream goes one way, so a client
/// may only send control frames: data frames, unmasked, fragmented, reserved or oversized ones are refused,
/// most of them by their first two bytes.
tl::expected<std::optional<ClientFrame>, WebSocketRefusal> read_client_frame(std::string_view arrived);

}  // namespace deixis
