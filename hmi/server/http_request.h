// One HTTP/1.1 request head: strict and bounded. Bytes in; a request out, or one sentence why not.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace deixis {

inline constexpr size_t max_request_head_bytes = 8192;
inline constexpr size_t max_request_target_bytes = 1024;

struct HttpRequest {
    std::string method;
    std::string path;   ///< percent-decoded, begins with '/', holds no "." or ".." segment
    std::string query;  ///< after '?', as sent
    std::map<std::string, std::string> headers;  ///< names in lower case, values trimmed

    /// The value of a header, empty when it is missing.
    std::string_view header(const std::string& lower_case_name) const;
};

struct HttpRefusal {
    int status = 400;
    std::string sentence;
};

/// Looks at what has arrived so far: the length of the complete head including its empty line, nothing while
/// it is still incomplete, or the refusal as soon as no continuation can heal it.
tl::expected<std::optional<size_t>, HttpRefusal> find_request_head(std::string_view arrived);

/// Parses a complete head (with its empty line). Refuses what is malformed, any version but HTTP/1.1, any
/// method but GET and HEAD, a missing or repeated Host, and every request with a body.
tl::expected<HttpRequest, HttpRefusal> parse_request_head(std::string_view head);

/// Whether a Host value (with or without port) names this machine's loopback: 127.0.0.1, [::1] or localhost.
bool is_loopback_host(std::string_view host);

}  // namespace deixis
