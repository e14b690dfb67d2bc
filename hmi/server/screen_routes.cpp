// The list of addresses and what stands behind each.
#include "hmi/server/screen_routes.h"

#include <algorithm>
#include <cctype>
#include <exception>

#include "hmi/server/screen_messages.h"
#include "hmi/server/web_socket_frames.h"

namespace deixis {
namespace {

HttpAnswer json_answer(std::string body) {
    return {200, "application/json", std::make_shared<const std::string>(std::move(body)), {}};
}

/// 304 without a body when the browser already holds these bytes. `no-cache`: keep it, but ask each time.
HttpAnswer cached_answer(const HttpRequest& request, std::string content_type, SharedBytes bytes,
                         const std::string& etag) {
    HttpAnswer answer{200, std::move(content_type), std::move(bytes), {}};
    answer.headers = {{"ETag", etag}, {"Cache-Control", "no-cache"}};
    if (request.header("if-none-match") == etag) {
        answer.status = 304;
        answer.body = nullptr;
    }
    return answer;
}

bool names_token(std::string_view list, std::string_view lower_case_token) {
    std::string lower(list);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (size_t begin = 0; begin <= lower.size();) {
        const size_t end = std::min(lower.find(',', begin), lower.size());
        std::string_view item = std::string_view(lower).substr(begin, end - begin);
        while (!item.empty() && item.front() == ' ') item.remove_prefix(1);
        while (!item.empty() && item.back() == ' ') item.remove_suffix(1);
        if (item == lower_case_token) return true;
        begin = end + 1;
    }
    return false;
}

HttpAnswer upgrade_answer(const HttpRequest& request, bool live_free) {
    if (request.method != "GET") return error_answer(405, "The live stream is opened with GET.");
    if (!names_token(request.header("upgrade"), "websocket") ||
        !names_token(request.header("connection"), "upgrade")) {
        HttpAnswer answer =
            error_answer(426, "/api/live is a WebSocket; the request does not ask for the upgrade.");
        answer.headers.emplace_back("Upgrade", "websocket");
        return answer;
    }
    if (request.header("sec-websocket-version") != "13") {
        HttpAnswer answer = error_answer(426, "Only WebSocket version 13 is spoken here.");
        answer.headers.emplace_back("Sec-WebSocket-Version", "13");
        return answer;
    }
    const std::string_view key = request.header("sec-websocket-key");
    if (!is_web_socket_key(key)) return error_answer(400, "Sec-WebSocket-Key is not 16 bytes in base64.");
    // A page of another site may open WebSockets to this machine; its browser tells us where it comes from.
    const std::string_view origin = request.header("origin");
    if (!origin.empty() && origin != "http://" + std::string(request.header("host")))
        return error_answer(403, "The live stream is for this station's own page, not for Origin '" +
                                     std::string(origin.substr(0, 100)) + "'.");
    if (!live_free)
        return error_answer(503, "As many screens as allowed are already watching; close one of them.");
    HttpAnswer answer{101, "", nullptr, {}};
    answer.headers = {{"Upgrade", "websocket"},
                      {"Connection", "Upgrade"},
                      {"Sec-WebSocket-Accept", web_socket_accept(key)}};
    return answer;
}

HttpAnswer state_answer(const LiveMessage* newest) {
    if (newest == nullptr) return json_answer(R"({"age_ms": null, "live": null})");
    const auto age = std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() -
                                                                           newest->published);
    return json_answer("{\"age_ms\": " + std::to_string(age.count()) + ", \"live\": " + newest->json + "}");
}

}  // namespace

HttpAnswer ScreenRoutes::answer(const HttpRequest& request, const LiveMessage* newest, bool live_free) {
    const std::string_view host = request.header("host");
    if (!is_loopback_host(host))
        return error_answer(421, "Host '" + std::string(host.substr(0, 100)) +
                                     "' is not this station; open it as 127.0.0.1 or localhost.");
    if (request.path.rfind("/api/", 0) == 0) {
        try {
            return api_answer(request, newest, live_free);
        } catch (const std::exception&) {
            return error_answer(500, "The station could not compose this answer; see its log.");
        }
    }
    const StaticFile* file = files_.find(request.path);
    if (file == nullptr) return error_answer(404, "There is nothing at this address.");
    return cached_answer(request, file->content_type, file->bytes, file->etag);
}

HttpAnswer ScreenRoutes::api_answer(const HttpRequest& request, const LiveMessage* newest, bool live_free) {
    if (!request.query.empty()) return error_answer(400, request.path + " takes no query.");
    if (request.path == "/api/live") return upgrade_answer(request, live_free);
    if (request.path == "/api/state") return state_answer(newest);
    if (request.path == "/api/part") return part_answer(request, false);
    if (request.path == "/api/part/mesh") return part_answer(request, true);
    if (request.path == "/api/marks") {
        const Result<std::string> marks = feed_.marks_json();
        return marks ? json_answer(*marks) : error_answer(503, marks.error().sentence);
    }
    if (request.path == "/api/cell") {
        const auto rig = feed_.rig();
        return json_answer(rig ? cell_json(*rig) : "null");
    }
    return error_answer(404, "There is nothing at this address.");
}

HttpAnswer ScreenRoutes::part_answer(const HttpRequest& request, bool mesh) {
    const auto part = feed_.part();
    if (!part) return mesh ? error_answer(404, "No part is known yet.") : json_answer("null");
    if (part != encoded_part_) {
        const std::vector<uint8_t> bytes = encode_mesh(part->mesh);
        mesh_bytes_ = std::make_shared<const std::string>(bytes.begin(), bytes.end());
        mesh_etag_ = entity_tag(*mesh_bytes_);
        encoded_part_ = part;
    }
    if (mesh) return cached_answer(request, "application/octet-stream", mesh_bytes_, mesh_etag_);
    return json_answer(part_json(*part, mesh_etag_));
}

}  // namespace deixis
