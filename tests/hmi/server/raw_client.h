// A client that sends whatever bytes it is told to, over a plain socket, and reads what comes back.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace deixis {

/// An HTTP answer taken apart.
struct RawAnswer {
    int status = 0;
    std::string head;  ///< status line and headers
    std::string body;

    /// Value of a header, empty when missing; names as the server writes them.
    std::string header(const std::string& name) const;
};

/// A WebSocket frame from the server.
struct RawFrame {
    int opcode = 0;
    std::string payload;

    int close_code() const;
    std::string close_reason() const;
};

/// Blocking, with a deadline of 10 s a call, so that a server that hangs fails the test instead of stopping
/// it.
class RawClient {
  public:
    explicit RawClient(int port);
    ~RawClient();
    RawClient(const RawClient&) = delete;
    RawClient& operator=(const RawClient&) = delete;

    /// False when the server has closed.
    bool send(std::string_view bytes);

    /// Everything until the server closes; nothing at the deadline.
    std::optional<std::string> read_to_end();

    /// `read_to_end`, taken apart; status 0 when it is no answer.
    RawAnswer answer();

    /// The head of a 101 and nothing after it; true when it is one.
    bool upgraded();

    /// The next frame; nothing when the server closed without one or at the deadline.
    std::optional<RawFrame> frame();

    /// Ends the connection as a crash would: a reset instead of a goodbye.
    void abort();

    /// As many bytes as the kernel keeps for us unread.
    void keep_little();

  private:
    bool fill();

    int socket_ = -1;
    std::string inbox_;
};

/// GET of a path with the Host that a browser would send.
std::string get_request(const std::string& path, const std::string& more_headers = "");

/// A valid request for the live stream.
std::string live_request();

/// A masked client frame.
std::string client_frame(int first_byte, std::string_view payload);

}  // namespace deixis
