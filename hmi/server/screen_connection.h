// One browser's connection: reads a request, writes the answer, or becomes a live stream. Never blocks.
#pragma once

#include <Poco/Net/StreamSocket.h>

#include <chrono>
#include <deque>
#include <memory>
#include <string>

#include "hmi/server/screen_routes.h"
#include "hmi/server/screen_server.h"

namespace deixis {

/// What a connection needs from the server around it; valid as long as the connection.
struct ConnectionSurroundings {
    const ScreenServerParams& params;
    ScreenRoutes& routes;
    const int& live_clients;
};

/// Driven by the server's loop: `want_read`/`want_write` say what to poll for, the `on_` calls react, `over`
/// tells when to drop it. Every phase has a deadline, so that no client can hold a place by doing nothing.
class ScreenConnection {
  public:
    using Clock = std::chrono::steady_clock;

    ScreenConnection(const Poco::Net::StreamSocket& socket, ConnectionSurroundings around,
                     Clock::time_point now);
    ~ScreenConnection();

    int handle() const;
    bool want_read() const { return phase_ != Phase::answering && phase_ != Phase::over; }
    bool want_write() const { return !outbox_.empty(); }
    bool over() const { return phase_ == Phase::over; }
    bool live() const { return phase_ == Phase::live; }
    bool waiting_for_request() const { return phase_ == Phase::requesting; }
    Clock::time_point born() const { return born_; }

    /// The next instant at which `on_time` has something to do although nothing arrives.
    Clock::time_point deadline(const LiveMessage* newest) const;

    void on_readable(Clock::time_point now, const LiveMessage* newest);
    void on_writable(Clock::time_point now);
    void on_time(Clock::time_point now, const LiveMessage* newest);

    /// Answers 503 at once, for a connection that there is no room for.
    void refuse_for_lack_of_room(Clock::time_point now);

    /// Says goodbye as far as the socket takes it without waiting, and is over.
    void end_now();

  private:
    enum class Phase { requesting, answering, live, lingering, over };

    void read_request(Clock::time_point now, const LiveMessage* newest);
    void read_live_frames(Clock::time_point now);
    void answer(const HttpAnswer& answer, bool with_body, Clock::time_point now);
    void close_live(uint16_t code, const std::string& reason, Clock::time_point now);
    void send_newest(Clock::time_point now, const LiveMessage& newest);
    void flush(Clock::time_point now);
    void linger(Clock::time_point now);
    void give_up();

    Poco::Net::StreamSocket socket_;
    ConnectionSurroundings around_;
    Phase phase_ = Phase::requesting;
    Clock::time_point born_;
    Clock::time_point phase_deadline_;  ///< of requesting, answering and lingering
    Clock::time_point last_progress_;   ///< when the socket last took bytes, or the outbox was last empty
    Clock::time_point last_live_send_;
    Clock::time_point last_heard_;
    Clock::time_point last_ping_;
    uint64_t last_sent_number_ = 0;
    size_t drained_bytes_ = 0;
    std::string inbox_;
    std::deque<SharedBytes> outbox_;
    size_t outbox_offset_ = 0;  ///< into its first entry
    bool last_words_ = false;   ///< a live stream whose close frame is in the outbox
};

}  // namespace deixis
