// The strict reader of request heads.
#include "hmi/server/http_request.h"

#include <algorithm>
#include <cctype>
#include <cstdio>

namespace deixis {
namespace {

tl::unexpected<HttpRefusal> refuse_request(int status, std::string sentence) {
    return tl::unexpected<HttpRefusal>(HttpRefusal{status, std::move(sentence)});
}

bool is_token(std::string_view text) {
    static constexpr std::string_view marks = "!#$%&'*+-.^_`|~";
    return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return c < 0x80 &&
               (std::isalnum(c) != 0 || marks.find(static_cast<char>(c)) != std::string_view::npos);
    });
}

std::string lower_case(std::string_view text) {
    std::string lower(text);
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) {
        return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    });
    return lower;
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

tl::expected<std::string, HttpRefusal> decode_path(std::string_view raw) {
    std::string path;
    for (size_t i = 0; i < raw.size(); ++i) {
        char c = raw[i];
        if (c == '%') {
            const int high = i + 2 < raw.size() ? hex_digit(raw[i + 1]) : -1;
            const int low = i + 2 < raw.size() ? hex_digit(raw[i + 2]) : -1;
            if (high < 0 || low < 0)
                return refuse_request(
                    400, "The request target holds '%' without two hexadecimal digits after it.");
            c = static_cast<char>(high * 16 + low);
            i += 2;
        }
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7F)
            return refuse_request(400, "The request target holds a control character.");
        if (c == '\\') return refuse_request(400, "The request target holds a backslash.");
        path += c;
    }
    for (size_t begin = 1; begin <= path.size();) {
        const size_t end = std::min(path.find('/', begin), path.size());
        const std::string_view segment = std::string_view(path).substr(begin, end - begin);
        if (segment == "." || segment == "..")
            return refuse_request(400, "The request target climbs with a '.' or '..' segment.");
        begin = end + 1;
    }
    return path;
}

tl::expected<HttpRequest, HttpRefusal> parse_request_line(std::string_view line) {
    const size_t first = line.find(' ');
    const size_t last = line.rfind(' ');
    if (first == std::string_view::npos || first == last ||
        line.substr(first + 1, last - first - 1).find(' ') != std::string_view::npos)
        return refuse_request(400, "The request line is not 'METHOD target HTTP/1.1'.");
    HttpRequest request;
    request.method = line.substr(0, first);
    const std::string_view target = line.substr(first + 1, last - first - 1);
    const std::string_view version = line.substr(last + 1);
    if (!is_token(request.method) || version.substr(0, 5) != "HTTP/")
        return refuse_request(400, "The request line is not 'METHOD target HTTP/1.1'.");
    if (version != "HTTP/1.1") return refuse_request(505, "Only HTTP/1.1 is spoken here.");
    if (request.method != "GET" && request.method != "HEAD")
        return refuse_request(405,
                              "Only GET and HEAD are served here, not " + request.method.substr(0, 20) + ".");
    if (target.size() > max_request_target_bytes)
        return refuse_request(
            414, "The request target is longer than " + std::to_string(max_request_target_bytes) + " bytes.");
    if (target.empty() || target.front() != '/')
        return refuse_request(400, "The request target does not begin with '/'.");
    const size_t question = std::min(target.find('?'), target.size());
    if (question < target.size()) request.query = target.substr(question + 1);
    auto path = decode_path(target.substr(0, question));
    if (!path) return tl::unexpected(path.error());
    request.path = std::move(*path);
    return request;
}

tl::expected<void, HttpRefusal> add_header(HttpRequest& request, std::string_view line) {
    if (line.front() == ' ' || line.front() == '\t')
        return refuse_request(400, "A header line begins with white space; folded headers are not accepted.");
    const size_t colon = line.find(':');
    if (colon == std::string_view::npos) return refuse_request(400, "A header line has no colon.");
    const std::string_view name = line.substr(0, colon);
    if (!is_token(name)) return refuse_request(400, "A header name holds a character that is not allowed.");
    std::string_view value = line.substr(colon + 1);
    while (!value.empty() && (value.front() == ' ' || value.front() == '\t')) value.remove_prefix(1);
    while (!value.empty() && (value.back() == ' ' || value.back() == '\t')) value.remove_suffix(1);
    const auto [at, fresh] = request.headers.emplace(lower_case(name), value);
    if (fresh) return {};
    if (at->first == "host") return refuse_request(400, "The request has more than one Host header.");
    at->second.append(", ").append(value);
    return {};
}

}  // namespace

std::string_view HttpRequest::header(const std::string& lower_case_name) const {
    const auto found = headers.find(lower_case_name);
    return found == headers.end() ? std::string_view{} : std::string_view(found->second);
}

tl::expected<std::optional<size_t>, HttpRefusal> find_request_head(std::string_view arrived) {
    const size_t looked_at = std::min(arrived.size(), max_request_head_bytes);
    for (size_t i = 0; i < looked_at; ++i) {
        const auto byte = static_cast<unsigned char>(arrived[i]);
        const bool after_return = i > 0 && arrived[i - 1] == '\r';
        if (after_return && byte != '\n')
            return refuse_request(400, "The request head holds a carriage return without a line feed.");
        if (byte == '\n') {
            if (!after_return)
                return refuse_request(400, "The request head holds a line feed without a carriage return.");
            if (i == 1) return refuse_request(400, "The request begins with an empty line.");
            if (i >= 3 && arrived[i - 2] == '\n') return i + 1;
        } else if ((byte < 0x20 && byte != '\t' && byte != '\r') || byte >= 0x7F) {
            char hex[8];
            std::snprintf(hex, sizeof hex, "0x%02x", byte);
            return refuse_request(400, std::string("The request head holds byte ") + hex + " at offset " +
                                           std::to_string(i) + "; only plain HTTP in ASCII is spoken here.");
        }
    }
    if (arrived.size() >= max_request_head_bytes)
        return refuse_request(
            431, "The request head is longer than " + std::to_string(max_request_head_bytes) + " bytes.");
    return std::nullopt;
}

tl::expected<HttpRequest, HttpRefusal> parse_request_head(std::string_view head) {
    size_t end = head.find("\r\n");
    auto request = parse_request_line(head.substr(0, end));
    if (!request) return request;
    for (size_t begin = end + 2; begin < head.size(); begin = end + 2) {
        end = std::min(head.find("\r\n", begin), head.size());
        if (end == begin) break;
        const auto added = add_header(*request, head.substr(begin, end - begin));
        if (!added) return tl::unexpected(added.error());
    }
    if (request->header("host").empty()) return refuse_request(400, "The request has no Host header.");
    if (request->headers.count("transfer-encoding") != 0)
        return refuse_request(413,
                              "A request body is not accepted, and this one announces Transfer-Encoding.");
    const std::string_view length = request->header("content-length");
    if (!length.empty() && length != "0")
        return refuse_request(413, "A request body is not accepted, and this one announces Content-Length.");
    return request;
}

bool is_loopback_host(std::string_view host) {
    const size_t colon = host.rfind(':');
    const bool has_port = colon != std::string_view::npos && (host.front() != '[' || host[colon - 1] == ']');
    if (has_port) {
        const std::string_view port = host.substr(colon + 1);
        if (port.empty() || port.size() > 5 ||
            !std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; }))
            return false;
        host = host.substr(0, colon);
    }
    const std::string name = lower_case(host);
    return name == "127.0.0.1" || name == "localhost" || name == "[::1]";
}

}  // namespace deixis
