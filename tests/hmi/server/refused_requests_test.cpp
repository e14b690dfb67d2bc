// Every bad request gets its status and its one sentence; none harms the next client.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "hmi/server/http_request.h"
#include "tests/hmi/server/made_up_screen.h"
#include "tests/hmi/server/raw_client.h"

namespace deixis {
namespace {

struct BadRequest {
    std::string bytes;
    int status;
    std::string sentence;
};

const std::string host = "Host: 127.0.0.1:8765\r\n";

std::string with_headers(const std::string& headers) {
    return "GET / HTTP/1.1\r\n" + headers + "\r\n";
}

std::vector<BadRequest> malformed_requests() {
    const std::string line = "The request line is not 'METHOD target HTTP/1.1'.";
    return {
        {"GET /\r\n\r\n", 400, line},
        {"GET\r\n\r\n", 400, line},
        {"GET / a HTTP/1.1\r\n\r\n", 400, line},
        {"G(T / HTTP/1.1\r\n\r\n", 400, line},
        {"GET / FTP/1.1\r\n\r\n", 400, line},
        {"\r\nGET / HTTP/1.1\r\n\r\n", 400, "The request begins with an empty line."},
        {"GET / HTTP/1.0\r\n" + host + "\r\n", 505, "Only HTTP/1.1 is spoken here."},
        {"GET / HTTP/2.0\r\n" + host + "\r\n", 505, "Only HTTP/1.1 is spoken here."},
        {"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 505, "Only HTTP/1.1 is spoken here."},
        {"GET / HTTP/1.1\n" + host + "\n", 400,
         "The request head holds a line feed without a carriage return."},
        {"GET / HTTP/1.1\rHost: x\r\n\r\n", 400,
         "The request head holds a carriage return without a line feed."},
        {std::string("GET /\0 HTTP/1.1\r\n\r\n", 19), 400,
         "The request head holds byte 0x00 at offset 5; only plain HTTP in ASCII is spoken here."},
        {"\x16\x03\x01\x02", 400,
         "The request head holds byte 0x16 at offset 0; only plain HTTP in ASCII is spoken here."},
        {"GET /\xC3\xA4 HTTP/1.1\r\n\r\n", 400,
         "The request head holds byte 0xc3 at offset 5; only plain HTTP in ASCII is spoken here."},
        {with_headers(host + "no colon here\r\n"), 400, "A header line has no colon."},
        {with_headers(host + "Bad Name: x\r\n"), 400, "A header name holds a character that is not allowed."},
        {with_headers(host + ": x\r\n"), 400, "A header name holds a character that is not allowed."},
        {with_headers(host + "A: b\r\n folded\r\n"), 400,
         "A header line begins with white space; folded headers are not accepted."},
        {with_headers(""), 400, "The request has no Host header."},
        {with_headers("Host:\r\n"), 400, "The request has no Host header."},
        {with_headers(host + host), 400, "The request has more than one Host header."},
        {with_headers(host + "Content-Length: 5\r\n") + "hello", 413,
         "A request body is not accepted, and this one announces Content-Length."},
        {with_headers(host + "Content-Length: 99999999999999999999\r\n"), 413,
         "A request body is not accepted, and this one announces Content-Length."},
        {with_headers(host + "Transfer-Encoding: chunked\r\n") + "5\r\nhello\r\n0\r\n\r\n", 413,
         "A request body is not accepted, and this one announces Transfer-Encoding."},
        {with_headers(host + "X: " + std::string(9000, 'x') + "\r\n"), 431,
         "The request head is longer than 8192 bytes."},
        {std::string(8192, 'A'), 431, "The request head is longer than 8192 bytes."},
        {"GET /" + std::string(1024, 'a') + " HTTP/1.1\r\n" + host + "\r\n", 414,
         "The request target is longer than 1024 bytes."},
    };
}

std::vector<BadRequest> refused_targets() {
    const auto target = [](const std::string& text) {
        return "GET " + text + " HTTP/1.1\r\n" + host + "\r\n";
    };
    const std::string climbs = "The request target climbs with a '.' or '..' segment.";
    const std::string percent = "The request target holds '%' without two hexadecimal digits after it.";
    const std::string slash = "The request target does not begin with '/'.";
    const std::string nothing = "There is nothing at this address.";
    return {
        {"POST / HTTP/1.1\r\n" + host + "\r\n", 405, "Only GET and HEAD are served here, not POST."},
        {"DELETE /api/marks HTTP/1.1\r\n" + host + "\r\n", 405,
         "Only GET and HEAD are served here, not DELETE."},
        {"OPTIONS * HTTP/1.1\r\n" + host + "\r\n", 405, "Only GET and HEAD are served here, not OPTIONS."},
        {"get / HTTP/1.1\r\n" + host + "\r\n", 405, "Only GET and HEAD are served here, not get."},
        {target("http://127.0.0.1/"), 400, slash},
        {target("*"), 400, slash},
        {target("/../secret.txt"), 400, climbs},
        {target("/fonts/../../secret.txt"), 400, climbs},
        {target("/%2e%2e/secret.txt"), 400, climbs},
        {target("/..%2fsecret.txt"), 400, climbs},
        {target("/./index.html"), 400, climbs},
        {target("/..\\secret.txt"), 400, "The request target holds a backslash."},
        {target("/%5c..%5csecret.txt"), 400, "The request target holds a backslash."},
        {target("/%"), 400, percent},
        {target("/%4"), 400, percent},
        {target("/%zz"), 400, percent},
        {target("/index.html%00.js"), 400, "The request target holds a control character."},
        {target("/%0d%0aSet-Cookie:x"), 400, "The request target holds a control character."},
        {target("/secret.txt"), 404, nothing},
        {target("/link.txt"), 404, nothing},
        {target("/fonts"), 404, nothing},
        {target("/fonts/"), 404, nothing},
        {target("//index.html"), 404, nothing},
        {target("/%252e%252e/secret.txt"), 404, nothing},
        {target("/api/"), 404, nothing},
        {target("/api/marks/1"), 404, nothing},
        {target("/api/marks?since=1"), 400, "/api/marks takes no query."},
        {target("/api/part/mesh"), 404, "No part is known yet."},
        {"GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n", 421,
         "Host 'evil.example' is not this station; open it as 127.0.0.1 or localhost."},
        {"GET / HTTP/1.1\r\nHost: 127.0.0.1.evil.example:8765\r\n\r\n", 421,
         "Host '127.0.0.1.evil.example:8765' is not this station; open it as 127.0.0.1 or localhost."},
        {"GET / HTTP/1.1\r\nHost: localhost:80x\r\n\r\n", 421,
         "Host 'localhost:80x' is not this station; open it as 127.0.0.1 or localhost."},
        {"GET / HTTP/1.1\r\nHost: :80\r\n\r\n", 421,
         "Host ':80' is not this station; open it as 127.0.0.1 or localhost."},
    };
}

/// The valid request for the live stream with one text in it replaced.
std::string live_with(const std::string& what, const std::string& by) {
    std::string request = live_request();
    const size_t at = request.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return request.replace(at, what.size(), by);
}

std::vector<BadRequest> refused_upgrades() {
    const std::string key = "Sec-WebSocket-Key is not 16 bytes in base64.";
    const std::string plain = "/api/live is a WebSocket; the request does not ask for the upgrade.";
    return {
        {get_request("/api/live"), 426, plain},
        {live_with("Upgrade: websocket", "Upgrade: h2c"), 426, plain},
        {live_with("keep-alive, Upgrade", "keep-alive"), 426, plain},
        {live_with("Version: 13", "Version: 8"), 426, "Only WebSocket version 13 is spoken here."},
        {live_with("Sec-WebSocket-Version: 13\r\n", ""), 426, "Only WebSocket version 13 is spoken here."},
        {live_with("Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n", ""), 400, key},
        {live_with("dGhlIHNhbXBsZSBub25jZQ==", "c2hvcnQ="), 400, key},
        {live_with("dGhlIHNhbXBsZSBub25jZQ==", "dGhlIHNhbXBsZSBub25jZ!=="), 400, key},
        {live_with("http://127.0.0.1:8765\r\n", "https://evil.example\r\n"), 403,
         "The live stream is for this station's own page, not for Origin 'https://evil.example'."},
        {live_with("http://127.0.0.1:8765\r\n", "null\r\n"), 403,
         "The live stream is for this station's own page, not for Origin 'null'."},
        {live_with("http://127.0.0.1:8765\r\n", "http://127.0.0.1:9999\r\n"), 403,
         "The live stream is for this station's own page, not for Origin 'http://127.0.0.1:9999'."},
        {live_with("GET", "HEAD"), 405, "The live stream is opened with GET."},
    };
}

class RefusedRequests : public testing::Test {
  protected:
    void expect_refused(const std::vector<BadRequest>& requests) {
        for (const BadRequest& bad : requests) {
            RawClient client(server->port());
            client.send(bad.bytes);
            const RawAnswer answer = client.answer();
            const std::string shown = bad.bytes.substr(0, 60);
            EXPECT_EQ(answer.status, bad.status) << shown;
            EXPECT_EQ(answer.header("Content-Type"), "application/json") << shown;
            if (bad.bytes.rfind("HEAD", 0) == 0) continue;
            EXPECT_EQ(answer.body, nlohmann::json({{"error", bad.sentence}}).dump() + "\n") << shown;
        }
        RawClient honest(server->port());
        honest.send(get_request("/"));
        EXPECT_EQ(honest.answer().status, 200);
    }

    MadeUpPage page;
    MadeUpFeed feed;
    std::unique_ptr<ScreenServer> server = must_start(test_params(page), feed);
};

TEST_F(RefusedRequests, MalformedOnes) {
    expect_refused(malformed_requests());
}

TEST_F(RefusedRequests, TargetsAndHosts) {
    expect_refused(refused_targets());
}

TEST_F(RefusedRequests, Upgrades) {
    expect_refused(refused_upgrades());
}

TEST_F(RefusedRequests, ClientFramesEndTheStreamWithTheReason) {
    struct BadFrame {
        std::string bytes;
        int code;
        std::string sentence;
    };
    const std::vector<BadFrame> frames = {
        {client_frame(0x81, "hello"), 1003, "The live stream takes no messages from clients."},
        {client_frame(0x82, "\x01"), 1003, "The live stream takes no messages from clients."},
        {client_frame(0x80, ""), 1003, "The live stream takes no messages from clients."},
        {std::string("\x89\x00", 2), 1002, "A client frame is not masked."},
        {client_frame(0xC9, ""), 1002, "A frame sets a reserved bit."},
        {client_frame(0x83, ""), 1002, "A frame has a reserved opcode."},
        {client_frame(0x8B, ""), 1002, "A frame has a reserved opcode."},
        {client_frame(0x09, ""), 1002, "A control frame is fragmented."},
        {std::string("\x89\xFE\x00\x7E", 4), 1002, "A control frame is longer than 125 bytes."},
        {std::string("\x89\xFF", 2), 1002, "A control frame is longer than 125 bytes."},
        {client_frame(0x88, "x"), 1002, "A close frame has a body of one byte."},
    };
    for (const BadFrame& bad : frames) {
        RawClient client(server->port());
        client.send(live_request());
        ASSERT_TRUE(client.upgraded());
        client.send(bad.bytes);
        const auto frame = client.frame();
        ASSERT_TRUE(frame) << bad.sentence;
        EXPECT_EQ(frame->opcode, 8);
        EXPECT_EQ(frame->close_code(), bad.code) << bad.sentence;
        EXPECT_EQ(frame->close_reason(), bad.sentence);
        EXPECT_FALSE(client.frame());
    }
}

TEST_F(RefusedRequests, RandomBytesNeverHarmTheServer) {
    std::mt19937 random(7);
    const std::string seed_text = live_request();
    for (int round = 0; round < 300; ++round) {
        std::string bytes = seed_text.substr(0, random() % (seed_text.size() + 1));
        for (auto change = random() % 6; change > 0 && !bytes.empty(); --change)
            bytes[random() % bytes.size()] = static_cast<char>(random());
        for (auto more = random() % 40; more > 0; --more) bytes += static_cast<char>(random());
        RawClient client(server->port());
        client.send(bytes);
        if (random() % 2 == 0) client.abort();
    }
    RawClient honest(server->port());
    honest.send(get_request("/api/marks"));
    EXPECT_EQ(honest.answer().body, "[]");
}

TEST(RequestHead, EveryPrefixIsIncompleteAndTheWholeIsFound) {
    const std::string whole = live_request();
    for (size_t size = 0; size < whole.size(); ++size) {
        const auto found = find_request_head(whole.substr(0, size));
        ASSERT_TRUE(found) << found.error().sentence;
        EXPECT_FALSE(*found) << size;
    }
    EXPECT_EQ(find_request_head(whole + "more").value(), whole.size());
}

TEST(RequestHead, PartsComeApart) {
    const auto request = parse_request_head(
        "HEAD /a%20b/c?d=e&f HTTP/1.1\r\nHOST: LocalHost\r\nX-Two:  1 \r\nx-two: 2\r\n\r\n");
    ASSERT_TRUE(request);
    EXPECT_EQ(request->method, "HEAD");
    EXPECT_EQ(request->path, "/a b/c");
    EXPECT_EQ(request->query, "d=e&f");
    EXPECT_EQ(request->header("host"), "LocalHost");
    EXPECT_EQ(request->header("x-two"), "1, 2");
    EXPECT_EQ(request->header("missing"), "");
}

TEST(LoopbackHost, OnlyThisMachineByItsOwnNames) {
    for (const char* name :
         {"127.0.0.1", "127.0.0.1:1", "localhost", "LOCALHOST:8765", "[::1]", "[::1]:65535"})
        EXPECT_TRUE(is_loopback_host(name)) << name;
    for (const char* name : {"", ":", ":80", "127.0.0.2", "::1", "[::1", "localhost.", "localhost:",
                             "127.0.0.1:123456", "evil.example", "[::1]x", "[::1]:", "127.0.0.1:80:80"})
        EXPECT_FALSE(is_loopback_host(name)) << name;
}

}  // namespace
}  // namespace deixis
