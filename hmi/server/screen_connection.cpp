// The life of one connection, phase by phase.
#include "hmi/server/screen_connection.h"

#include <Poco/Exception.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "hmi/server/http_request.h"
#include "hmi/server/web_socket_frames.h"

namespace deixis {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds linger_time{1000};
constexpr milliseconds ping_interval{5000};
constexpr milliseconds silence_limit{20000};
constexpr size_t max_drained_bytes = 1U << 20U;
// Bounds how much stale live data the kernel holds for a slow client.
constexpr int live_send_buffer_bytes = 256 * 1024;

/// Poco throws also when a socket that must not block would have to; depending on the call, with either of
/// these.
bool means_not_now(const Poco::Exception& error) {
    return error.code() == EAGAIN || error.code() == EINTR ||
           dynamic_cast<const Poco::TimeoutException*>(&error) != nullptr;
}

/// False where the client is gone and `act` cannot be done to its socket any more.
template <class Act>
bool unless_gone(const Act& act) {
    try {
        act();
        return true;
    } catch (const Poco::Exception&) {
        return false;
    }
}

SharedBytes shared(std::string bytes) {
    return std::make_shared<const std::string>(std::move(bytes));
}

}  // namespace

ScreenConnection::ScreenConnection(const Poco::Net::StreamSocket& socket, ConnectionSurroundings around,
                                   Clock::time_point now)
    : socket_(socket),
      around_(around),
      born_(now),
      phase_deadline_(now + milliseconds(around.params.request_timeout_ms)),
      last_progress_(now),
      last_heard_(now),
      last_ping_(now) {}

ScreenConnection::~ScreenConnection() {
    unless_gone([&] { socket_.close(); });
}

int ScreenConnection::handle() const {
    return socket_.impl()->sockfd();
}

ScreenConnection::Clock::time_point ScreenConnection::deadline(const LiveMessage* newest) const {
    if (phase_ != Phase::live) return phase_deadline_;
    Clock::time_point next = std::min(last_ping_ + ping_interval, last_heard_ + silence_limit);
    if (!outbox_.empty())
        return std::min(next, last_progress_ + milliseconds(around_.params.slow_client_timeout_ms));
    if (newest != nullptr && newest->number != last_sent_number_)
        next = std::min(next,
                        last_live_send_ + std::chrono::duration_cast<Clock::duration>(
                                              std::chrono::duration<double>(1.0 / around_.params.live_hz)));
    return next;
}

void ScreenConnection::on_readable(Clock::time_point now, const LiveMessage* newest) {
    std::array<char, 16384> buffer;
    int received = 0;
    try {
        received = socket_.receiveBytes(buffer.data(), static_cast<int>(buffer.size()));
    } catch (const Poco::Exception& error) {
        if (!means_not_now(error)) phase_ = Phase::over;  // reset by the client
        return;
    }
    if (received < 0) return;  // nothing there after all
    if (received == 0) {
        phase_ = Phase::over;
        return;
    }
    last_heard_ = now;
    if (phase_ == Phase::lingering) {
        drained_bytes_ += static_cast<size_t>(received);
        if (drained_bytes_ > max_drained_bytes) phase_ = Phase::over;
        return;
    }
    inbox_.append(buffer.data(), static_cast<size_t>(received));
    if (phase_ == Phase::requesting) read_request(now, newest);
    if (phase_ == Phase::live) read_live_frames(now);
}

void ScreenConnection::read_request(Clock::time_point now, const LiveMessage* newest) {
    const auto head = find_request_head(inbox_);
    if (!head) return answer(error_answer(head.error().status, head.error().sentence), true, now);
    if (!*head) return;
    const auto request = parse_request_head(std::string_view(inbox_).substr(0, **head));
    if (!request) return answer(error_answer(request.error().status, request.error().sentence), true, now);
    inbox_.erase(0, **head);
    const bool live_free = around_.live_clients < around_.params.max_live_clients;
    const HttpAnswer composed = around_.routes.answer(*request, newest, live_free);
    if (composed.status != 101) return answer(composed, request->method == "GET", now);

    socket_.setSendBufferSize(live_send_buffer_bytes);
    outbox_.push_back(shared(head_of(composed)));
    phase_ = Phase::live;
    last_ping_ = last_progress_ = now;
    if (newest != nullptr) last_sent_number_ = newest->number;  // it may be old: live means from now on
    flush(now);
}

void ScreenConnection::read_live_frames(Clock::time_point now) {
    while (phase_ == Phase::live && !last_words_) {
        const auto frame = read_client_frame(inbox_);
        if (!frame) return close_live(frame.error().code, frame.error().sentence, now);
        if (!*frame) return;
        inbox_.erase(0, (*frame)->bytes);
        if ((*frame)->opcode == WebSocketOpcode::close) return close_live(1000, "", now);
        // A client that pings faster than it reads would make the outbox grow: its pings go unanswered
        // meanwhile.
        if ((*frame)->opcode == WebSocketOpcode::ping && outbox_.size() < 8) {
            outbox_.push_back(shared(encode_web_socket_frame(WebSocketOpcode::pong, (*frame)->payload)));
            flush(now);
        }
    }
    inbox_.clear();
}

void ScreenConnection::answer(const HttpAnswer& answer, bool with_body, Clock::time_point now) {
    outbox_.push_back(shared(head_of(answer)));
    if (with_body && answer.body && !answer.body->empty()) outbox_.push_back(answer.body);
    phase_ = Phase::answering;
    phase_deadline_ = now + milliseconds(around_.params.response_timeout_ms);
    flush(now);
}

void ScreenConnection::close_live(uint16_t code, const std::string& reason, Clock::time_point now) {
    outbox_.push_back(shared(encode_web_socket_close(code, reason)));
    last_words_ = true;
    flush(now);
}

void ScreenConnection::send_newest(Clock::time_point now, const LiveMessage& newest) {
    last_sent_number_ = newest.number;
    last_live_send_ = last_progress_ = now;
    outbox_.push_back(newest.json_frame);
    if (newest.voxel_frame) outbox_.push_back(newest.voxel_frame);
    flush(now);
}

void ScreenConnection::on_writable(Clock::time_point now) {
    flush(now);
}

void ScreenConnection::flush(Clock::time_point now) {
    while (!outbox_.empty()) {
        const std::string& front = *outbox_.front();
        int sent = 0;
        try {
            sent = socket_.sendBytes(front.data() + outbox_offset_,
                                     static_cast<int>(front.size() - outbox_offset_), MSG_NOSIGNAL);
        } catch (const Poco::Exception& error) {
            if (means_not_now(error)) return;
            phase_ = Phase::over;
            outbox_.clear();
            return;
        }
        if (sent <= 0) return;
        last_progress_ = now;
        outbox_offset_ += static_cast<size_t>(sent);
        if (outbox_offset_ < front.size()) continue;
        outbox_.pop_front();
        outbox_offset_ = 0;
    }
    if (phase_ == Phase::answering || last_words_) linger(now);
}

// Closing with unread input would reset the connection and could take the answer away from the client.
void ScreenConnection::linger(Clock::time_point now) {
    phase_ = Phase::lingering;
    last_words_ = false;
    phase_deadline_ = now + linger_time;
    if (!unless_gone([&] { socket_.shutdownSend(); })) phase_ = Phase::over;
}

void ScreenConnection::on_time(Clock::time_point now, const LiveMessage* newest) {
    switch (phase_) {
        case Phase::requesting:
            if (now >= phase_deadline_)
                answer(error_answer(408, "The request head did not arrive within " +
                                             std::to_string(around_.params.request_timeout_ms) + " ms."),
                       true, now);
            return;
        case Phase::answering:
        case Phase::lingering:
            if (now >= phase_deadline_) give_up();
            return;
        case Phase::over:
            return;
        case Phase::live:
            break;
    }
    const bool stuck =
        !outbox_.empty() && now >= last_progress_ + milliseconds(around_.params.slow_client_timeout_ms);
    if (stuck || now >= last_heard_ + silence_limit) return give_up();
    if (!outbox_.empty() || now < deadline(newest)) return;
    if (now >= last_ping_ + ping_interval) {
        last_ping_ = now;
        outbox_.push_back(shared(encode_web_socket_frame(WebSocketOpcode::ping, "")));
    }
    if (newest != nullptr && newest->number != last_sent_number_)
        send_newest(now, *newest);
    else
        flush(now);
}

void ScreenConnection::refuse_for_lack_of_room(Clock::time_point now) {
    answer(error_answer(503, "Too many connections are open; try again."), true, now);
}

// What the client has not fetched in its time is dropped, in the kernel too.
void ScreenConnection::give_up() {
    phase_ = Phase::over;
    unless_gone([&] { socket_.setLinger(true, 0); });
}

void ScreenConnection::end_now() {
    unless_gone([&] {
        if (phase_ == Phase::live && outbox_.empty()) {
            const std::string goodbye = encode_web_socket_close(1001, "The station is stopping.");
            socket_.sendBytes(goodbye.data(), static_cast<int>(goodbye.size()), MSG_NOSIGNAL);
        }
        socket_.shutdown();
    });
    phase_ = Phase::over;
}

}  // namespace deixis
