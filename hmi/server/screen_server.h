// The station's screen over HTTP and WebSocket: static files, the part, the marks, and the live stream.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hmi/server/screen_feed.h"
#include "tracking/geometry/result.h"

namespace deixis {

struct ScreenServerParams {
    std::string host = "127.0.0.1";     ///< loopback only: "127.0.0.1", "::1" or "localhost"
    int port = 8765;                    ///< 0: any free one, see `ScreenServer::port`
    std::string web_root;               ///< folder of the built hmi/web, read once at start
    int max_connections = 64;           ///< of any kind; the longest-waiting half-sent request makes room
    int max_live_clients = 8;           ///< WebSockets, so that they never crowd out the rest
    double live_hz = 15;                ///< most live messages a second and client
    int request_timeout_ms = 5000;      ///< from connect to the complete request head
    int response_timeout_ms = 15000;    ///< from the first to the last byte of an answer
    int slow_client_timeout_ms = 3000;  ///< a live client that takes nothing for this long is dropped

    InvalidSettings validate() const;
};

/// One thread of its own serves everything without blocking on any client. Endpoints: see openapi.yaml beside
/// this.
class ScreenServer {
  public:
    /// Refuses invalid parameters, a host that is not loopback, a port in use, and a web_root without
    /// index.html. `feed` must outlive the server.
    static Result<std::unique_ptr<ScreenServer>> start(const ScreenServerParams& params, ScreenFeed& feed);

    ~ScreenServer();  ///< stops
    ScreenServer(const ScreenServer&) = delete;
    ScreenServer& operator=(const ScreenServer&) = delete;

    /// The port it really listens on.
    int port() const;

    /// "http://127.0.0.1:8765/", for a person to open.
    std::string address() const;

    /// Hands the newest live message to every client: `live_json` is one JSON object (see openapi.yaml,
    /// LiveMessage), `voxels` from `encode_voxels` or empty. Never blocks; any thread. A client still busy
    /// with an older message gets the newest one next and skips those between. Publish also without a frame
    /// ("frame": null) a few times a second, so that the screen can name what is missing.
    void publish(std::string live_json, std::vector<uint8_t> voxels);

    /// Ends every connection (live ones with a close frame) and joins the thread; within milliseconds.
    /// Idempotent.
    void stop();

  private:
    struct Impl;
    explicit ScreenServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace deixis
