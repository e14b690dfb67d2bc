// The server's one loop: waits, serves every connection a little, accepts, hands out the newest message.
#include "hmi/server/screen_server.h"

#include <Poco/Exception.h>
#include <Poco/Net/ServerSocket.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <mutex>
#include <thread>

#include "hmi/server/screen_connection.h"
#include "hmi/server/web_socket_frames.h"

namespace deixis {
namespace {

using Clock = ScreenConnection::Clock;

bool is_loopback_name(const std::string& host) {
    return host == "127.0.0.1" || host == "::1" || host == "localhost";
}

std::string url_host(const std::string& host) {
    return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

void require_between(InvalidSettings& complaints, const char* key, int value, int low, int high) {
    if (value >= low && value <= high) return;
    complaints.push_back({key, std::to_string(value), std::to_string(low) + " to " + std::to_string(high)});
}

}  // namespace

InvalidSettings ScreenServerParams::validate() const {
    InvalidSettings complaints;
    if (!is_loopback_name(host)) complaints.push_back({"host", host, "127.0.0.1, ::1 or localhost"});
    require_between(complaints, "port", port, 0, 65535);
    if (web_root.empty()) complaints.push_back({"web_root", web_root, "a folder with index.html"});
    require_between(complaints, "max_connections", max_connections, 2, 1000);
    require_between(complaints, "max_live_clients", max_live_clients, 1, std::max(1, max_connections - 1));
    require_range(complaints, "live_hz", live_hz, 0.1, 60);
    require_between(complaints, "request_timeout_ms", request_timeout_ms, 50, 60000);
    require_between(complaints, "response_timeout_ms", response_timeout_ms, 50, 600000);
    require_between(complaints, "slow_client_timeout_ms", slow_client_timeout_ms, 50, 600000);
    return complaints;
}

struct ScreenServer::Impl {
    Impl(const ScreenServerParams& chosen, StaticFiles files, ScreenFeed& feed,
         const Poco::Net::ServerSocket& listening)
        : params(chosen),
          routes(std::move(files), feed),
          listener(listening),
          wake(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}
    ~Impl() {
        if (wake >= 0) ::close(wake);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void run();
    void wait_for_something(const LiveMessage* newest);
    void accept_waiting(Clock::time_point now);
    void make_room();
    void ring() const {
        const uint64_t one = 1;
        // Fails only when the counter is full, and then the loop is awake anyway.
        [[maybe_unused]] const auto written = ::write(wake, &one, sizeof one);
    }
    std::shared_ptr<const LiveMessage> newest_message() {
        const std::lock_guard lock(mailbox_mutex);
        return mailbox;
    }

    const ScreenServerParams params;
    ScreenRoutes routes;
    Poco::Net::ServerSocket listener;
    const int wake;
    int port = 0;

    std::mutex mailbox_mutex;
    std::shared_ptr<const LiveMessage> mailbox;  ///< the newest message, guarded by `mailbox_mutex`
    uint64_t published = 0;                      ///< guarded by `mailbox_mutex`
    std::atomic<bool> stopping{false};
    std::thread thread;

    // Of the loop's thread alone:
    std::vector<std::unique_ptr<ScreenConnection>> connections;
    std::vector<pollfd> polled;
    int live_clients = 0;
    Clock::time_point accept_again;  ///< after the system refused us a descriptor
};

void ScreenServer::Impl::run() {
    while (!stopping.load()) {
        auto newest = newest_message();
        wait_for_something(newest.get());
        const size_t served = polled.size() - 2;  // those that were polled; accepting adds more behind them
        const Clock::time_point now = Clock::now();
        newest = newest_message();
        for (size_t i = 0; i < served; ++i) {
            ScreenConnection& connection = *connections[i];
            const short events = polled[i + 2].revents;
            const bool was_live = connection.live();
            if ((events & (POLLIN | POLLHUP | POLLERR)) != 0 && connection.want_read())
                connection.on_readable(now, newest.get());
            if ((events & (POLLHUP | POLLERR)) != 0 && !connection.want_read() && !connection.over())
                connection.end_now();
            if ((events & POLLOUT) != 0 && !connection.over()) connection.on_writable(now);
            if (!connection.over()) connection.on_time(now, newest.get());
            live_clients += static_cast<int>(connection.live()) - static_cast<int>(was_live);
        }
        if ((polled[1].revents & POLLIN) != 0) accept_waiting(now);
        std::erase_if(connections, [](const auto& connection) { return connection->over(); });
    }
    for (const auto& connection : connections) connection->end_now();
    connections.clear();
}

void ScreenServer::Impl::wait_for_something(const LiveMessage* newest) {
    Clock::time_point until = Clock::now() + std::chrono::seconds(60);
    const bool accepting = Clock::now() >= accept_again;
    if (!accepting) until = accept_again;
    polled.assign(
        {{wake, POLLIN, 0}, {listener.impl()->sockfd(), static_cast<short>(accepting ? POLLIN : 0), 0}});
    for (const auto& connection : connections) {
        const int events = (connection->want_read() ? POLLIN : 0) | (connection->want_write() ? POLLOUT : 0);
        polled.push_back({connection->handle(), static_cast<short>(events), 0});
        until = std::min(until, connection->deadline(newest));
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    ::poll(polled.data(), polled.size(), static_cast<int>(std::max<int64_t>(0, left)));
    uint64_t rings = 0;
    [[maybe_unused]] const auto got = ::read(wake, &rings, sizeof rings);
}

void ScreenServer::Impl::accept_waiting(Clock::time_point now) {
    for (int i = 0; i < 16; ++i) {
        try {
            if (!listener.poll(Poco::Timespan(0, 0), Poco::Net::Socket::SELECT_READ)) return;
            Poco::Net::StreamSocket socket = listener.acceptConnection();
            socket.setBlocking(false);
            socket.setNoDelay(true);
            make_room();
            const bool room = connections.size() < static_cast<size_t>(params.max_connections);
            auto connection = std::make_unique<ScreenConnection>(
                socket, ConnectionSurroundings{params, routes, live_clients}, now);
            if (!room) connection->refuse_for_lack_of_room(now);
            // Refused ones linger for a second at most; beyond twice the room they are dropped without a
            // word.
            if (room || connections.size() < 2 * static_cast<size_t>(params.max_connections))
                connections.push_back(std::move(connection));
        } catch (const Poco::Exception&) {
            // The client is gone again, or the process is out of descriptors: try again a little later.
            accept_again = now + std::chrono::milliseconds(100);
            return;
        }
    }
}

// A full house of half-sent requests must not lock honest browsers out: the longest-waiting one goes.
void ScreenServer::Impl::make_room() {
    if (connections.size() < static_cast<size_t>(params.max_connections)) return;
    const auto oldest =
        std::min_element(connections.begin(), connections.end(), [](const auto& a, const auto& b) {
            if (a->waiting_for_request() != b->waiting_for_request()) return a->waiting_for_request();
            return a->born() < b->born();
        });
    if ((*oldest)->waiting_for_request()) connections.erase(oldest);
}

Result<std::unique_ptr<ScreenServer>> ScreenServer::start(const ScreenServerParams& params,
                                                          ScreenFeed& feed) {
    if (!is_loopback_name(params.host))
        return fail("screen.host '" + params.host +
                    "' is not a loopback address; the screen is served on 127.0.0.1, ::1 or localhost only.");
    const InvalidSettings complaints = params.validate();
    if (!complaints.empty())
        return fail("screen." + complaints.front().key + " is '" + complaints.front().value + "', expected " +
                    complaints.front().range + ".");
    auto files = StaticFiles::read(params.web_root);
    if (!files) return tl::unexpected(files.error());

    Poco::Net::ServerSocket listener;
    try {
        // Without the third argument Poco also sets SO_REUSEPORT, and two stations would share the port
        // silently.
        const Poco::Net::SocketAddress address(params.host, static_cast<Poco::UInt16>(params.port));
        listener.bind(address, true, false);
        listener.listen(64);
        listener.setBlocking(false);
    } catch (const Poco::Exception& error) {
        if (error.code() == EADDRINUSE)
            return fail("Port " + std::to_string(params.port) + " on " + params.host +
                        " is already in use; stop the other program or choose another screen.port.");
        return fail("Port " + std::to_string(params.port) + " on " + params.host +
                    " cannot be opened: " + error.displayText() + ".");
    }
    auto impl = std::make_unique<Impl>(params, std::move(*files), feed, listener);
    impl->port = impl->listener.address().port();
    if (impl->wake < 0) return fail("The screen server got no event descriptor from the system.");
    impl->thread = std::thread([loop = impl.get()] { loop->run(); });
    return std::unique_ptr<ScreenServer>(new ScreenServer(std::move(impl)));
}

ScreenServer::ScreenServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

ScreenServer::~ScreenServer() {
    stop();
}

int ScreenServer::port() const {
    return impl_->port;
}

std::string ScreenServer::address() const {
    return "http://" + url_host(impl_->params.host) + ":" + std::to_string(impl_->port);
}

void ScreenServer::publish(std::string live_json, std::vector<uint8_t> voxels) {
    auto message = std::make_shared<LiveMessage>();
    message->published = Clock::now();
    message->json_frame =
        std::make_shared<const std::string>(encode_web_socket_frame(WebSocketOpcode::text, live_json));
    message->json = std::move(live_json);
    if (!voxels.empty())
        message->voxel_frame = std::make_shared<const std::string>(encode_web_socket_frame(
            WebSocketOpcode::binary, {reinterpret_cast<const char*>(voxels.data()), voxels.size()}));
    {
        const std::lock_guard lock(impl_->mailbox_mutex);
        message->number = ++impl_->published;
        impl_->mailbox = std::move(message);
    }
    impl_->ring();
}

void ScreenServer::stop() {
    impl_->stopping.store(true);
    impl_->ring();
    if (impl_->thread.joinable()) impl_->thread.join();
    impl_->listener.close();
}

}  // namespace deixis
