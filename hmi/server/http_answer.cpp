// The bytes of an answer's head, and the headers that every answer carries.
#include "hmi/server/http_answer.h"

#include <Poco/DigestEngine.h>
#include <Poco/Net/HTTPResponse.h>
#include <Poco/SHA1Engine.h>

#include <nlohmann/json.hpp>

namespace deixis {

HttpAnswer error_answer(int status, std::string_view sentence) {
    const nlohmann::json body = {{"error", sentence}};
    HttpAnswer answer{status,
                      "application/json",
                      std::make_shared<const std::string>(
                          body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n"),
                      {}};
    if (status == 405) answer.headers.emplace_back("Allow", "GET, HEAD");
    return answer;
}

std::string head_of(const HttpAnswer& answer) {
    const auto status = static_cast<Poco::Net::HTTPResponse::HTTPStatus>(answer.status);
    std::string head = "HTTP/1.1 " + std::to_string(answer.status) + " " +
                       Poco::Net::HTTPResponse::getReasonForStatus(status) + "\r\n";
    const auto add = [&head](std::string_view name, std::string_view value) {
        head.append(name).append(": ").append(value).append("\r\n");
    };
    bool has_cache_rule = false;
    for (const auto& [name, value] : answer.headers) {
        add(name, value);
        has_cache_rule = has_cache_rule || name == "Cache-Control";
    }
    if (answer.status != 101) {
        if (!answer.content_type.empty()) add("Content-Type", answer.content_type);
        if (answer.status != 304)
            add("Content-Length", std::to_string(answer.body ? answer.body->size() : 0));
        if (!has_cache_rule) add("Cache-Control", "no-store");
        add("Connection", "close");
    }
    add("Content-Security-Policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; font-src 'self'; "
        "connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    add("X-Content-Type-Options", "nosniff");
    add("X-Frame-Options", "DENY");
    add("Referrer-Policy", "no-referrer");
    add("Cross-Origin-Opener-Policy", "same-origin");
    add("Cross-Origin-Resource-Policy", "same-origin");
    add("Permissions-Policy", "camera=(), geolocation=(), microphone=()");
    return head + "\r\n";
}

std::string entity_tag(std::string_view bytes) {
    Poco::SHA1Engine digest;
    digest.update(bytes.data(), bytes.size());
    std::string tag = "\"";
    return tag.append(Poco::DigestEngine::digestToHex(digest.digest()), 0, 20).append("\"");
}

}  // namespace deixis
