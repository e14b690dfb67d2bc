// Which request gets which answer: static files, /api/*, and the upgrade to the live stream.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "hmi/server/http_answer.h"
#include "hmi/server/http_request.h"
#include "hmi/server/screen_feed.h"
#include "hmi/server/static_files.h"

namespace deixis {

/// One published live message: as it was handed in, and framed for the WebSocket once for all clients.
struct LiveMessage {
    uint64_t number = 0;  ///< counts up from 1
    std::chrono::steady_clock::time_point published;
    std::string json;
    SharedBytes json_frame;
    SharedBytes voxel_frame;  ///< null: no voxels with this one
};

class ScreenRoutes {
  public:
    ScreenRoutes(StaticFiles files, ScreenFeed& feed) : files_(std::move(files)), feed_(feed) {}

    /// Never throws. Status 101 means: this connection becomes a live one (granted only if `live_free`).
    /// newest  the last published message, null before the first
    HttpAnswer answer(const HttpRequest& request, const LiveMessage* newest, bool live_free);

  private:
    HttpAnswer api_answer(const HttpRequest& request, const LiveMessage* newest, bool live_free);
    HttpAnswer part_answer(const HttpRequest& request, bool mesh);

    StaticFiles files_;
    ScreenFeed& feed_;
    std::shared_ptr<const ScreenPart> encoded_part_;  ///< whose mesh `mesh_bytes_` holds
    SharedBytes mesh_bytes_;
    std::string mesh_etag_;
};

}  // namespace deixis
