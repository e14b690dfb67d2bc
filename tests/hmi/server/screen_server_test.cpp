// The server as a whole: what it serves, how the live stream behaves, and that no client can hurt the others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "hmi/server/screen_messages.h"
#include "tests/hmi/server/made_up_screen.h"
#include "tests/hmi/server/raw_client.h"

namespace deixis {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

class ScreenServing : public testing::Test {
  protected:
    void start() { server = must_start(params, feed); }

    RawAnswer get(const std::string& path, const std::string& headers = "") {
        RawClient client(server->port());
        client.send(get_request(path, headers));
        return client.answer();
    }

    std::unique_ptr<RawClient> live_client() {
        auto client = std::make_unique<RawClient>(server->port());
        client->send(live_request());
        EXPECT_TRUE(client->upgraded());
        return client;
    }

    /// Publishes until the condition holds; false after 10 s.
    bool publish_until(const std::function<bool()>& done, size_t voxel_bytes = 0) {
        for (const auto end = Clock::now() + seconds(10); Clock::now() < end;) {
            server->publish(R"({"n": )" + std::to_string(++published) + "}",
                            std::vector<uint8_t>(voxel_bytes, 7));
            if (done()) return true;
            std::this_thread::yield();
        }
        return false;
    }

    MadeUpPage page;
    MadeUpFeed feed;
    ScreenServerParams params = test_params(page);
    std::unique_ptr<ScreenServer> server;
    int published = 0;
};

TEST_F(ScreenServing, FilesWithTheirTypesAndTheHeadersThatProtect) {
    start();
    const RawAnswer index = get("/");
    EXPECT_EQ(index.status, 200);
    EXPECT_EQ(index.body, "<!doctype html><title>page</title>");
    EXPECT_EQ(index.header("Content-Type"), "text/html; charset=utf-8");
    EXPECT_EQ(index.header("Content-Length"), std::to_string(index.body.size()));
    EXPECT_EQ(index.header("Connection"), "close");
    EXPECT_EQ(index.header("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(index.header("X-Frame-Options"), "DENY");
    EXPECT_EQ(index.header("Referrer-Policy"), "no-referrer");
    EXPECT_EQ(index.header("Cross-Origin-Resource-Policy"), "same-origin");
    const std::string policy = index.header("Content-Security-Policy");
    EXPECT_THAT(policy, testing::HasSubstr("default-src 'none'; script-src 'self'; style-src 'self'"));
    EXPECT_THAT(policy, testing::Not(testing::HasSubstr("unsafe")));
    EXPECT_EQ(get("/index.html").body, index.body);
    EXPECT_EQ(get("/app.js").header("Content-Type"), "text/javascript; charset=utf-8");
    EXPECT_EQ(get("/fonts/a.woff2").header("Content-Type"), "font/woff2");
}

TEST_F(ScreenServing, WhatTheBrowserHoldsIsNotSentAgain) {
    start();
    const std::string tag = get("/app.js").header("ETag");
    ASSERT_FALSE(tag.empty());
    const RawAnswer again = get("/app.js", "If-None-Match: " + tag + "\r\n");
    EXPECT_EQ(again.status, 304);
    EXPECT_EQ(again.body, "");
    EXPECT_EQ(get("/app.js", "If-None-Match: \"other\"\r\n").status, 200);
}

TEST_F(ScreenServing, HeadHasNoBody) {
    start();
    RawClient client(server->port());
    client.send("HEAD / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    const RawAnswer answer = client.answer();
    EXPECT_EQ(answer.status, 200);
    EXPECT_EQ(answer.header("Content-Length"), "34");
    EXPECT_EQ(answer.body, "");
}

TEST_F(ScreenServing, PartCellAndMarks) {
    feed.known_part = made_up_part();
    feed.known_rig = std::make_shared<SensorRig>();
    feed.marks = [] { return Result<std::string>(R"([{"id": 1}])"); };
    start();
    const auto part = nlohmann::json::parse(get("/api/part").body);
    EXPECT_EQ(part.at("serial"), "0001");
    const RawAnswer mesh = get("/api/part/mesh");
    const auto expected = encode_mesh(feed.known_part->mesh);
    EXPECT_EQ(mesh.body, std::string(expected.begin(), expected.end()));
    EXPECT_EQ(mesh.header("ETag"), part.at("mesh_etag"));
    EXPECT_EQ(get("/api/part/mesh", "If-None-Match: " + mesh.header("ETag") + "\r\n").status, 304);
    EXPECT_EQ(get("/api/cell").body, R"({"sensors":[],"cell":null})");
    EXPECT_EQ(get("/api/marks").body, R"([{"id": 1}])");
    EXPECT_EQ(get("/api/marks").header("Cache-Control"), "no-store");
}

TEST_F(ScreenServing, WhatIsNotKnownIsNull) {
    start();
    EXPECT_EQ(get("/api/part").body, "null");
    EXPECT_EQ(get("/api/cell").body, "null");
    EXPECT_EQ(get("/api/state").body, R"({"age_ms": null, "live": null})");
}

TEST_F(ScreenServing, AnotherPartHasAnotherTag) {
    feed.known_part = made_up_part();
    start();
    const std::string first = get("/api/part/mesh").header("ETag");
    server->stop();
    auto other = std::make_shared<ScreenPart>(*feed.known_part);
    other->mesh.vertices[0].x() = 0.5F;
    feed.known_part = other;
    start();
    EXPECT_NE(get("/api/part/mesh").header("ETag"), first);
}

TEST_F(ScreenServing, AFeedThatFailsIsNamedAndOneThatThrowsIsSurvived) {
    feed.marks = [] { return Result<std::string>(fail("The record 'defects.db' cannot be read.")); };
    start();
    EXPECT_EQ(get("/api/marks").status, 503);
    EXPECT_EQ(get("/api/marks").body, "{\"error\":\"The record 'defects.db' cannot be read.\"}\n");
    server->stop();
    feed.marks = []() -> Result<std::string> { throw std::runtime_error("bug"); };
    start();
    const RawAnswer answer = get("/api/marks");
    EXPECT_EQ(answer.status, 500);
    EXPECT_EQ(answer.body, "{\"error\":\"The station could not compose this answer; see its log.\"}\n");
    EXPECT_EQ(get("/").status, 200);
}

TEST_F(ScreenServing, TheLiveStreamBringsTextThenVoxels) {
    start();
    const auto client = live_client();
    server->publish(R"({"frame": null})", {1, 2, 3});
    const auto text = client->frame();
    ASSERT_TRUE(text);
    EXPECT_EQ(text->opcode, 1);
    EXPECT_EQ(text->payload, R"({"frame": null})");
    const auto voxels = client->frame();
    ASSERT_TRUE(voxels);
    EXPECT_EQ(voxels->opcode, 2);
    EXPECT_EQ(voxels->payload, std::string("\x01\x02\x03"));
    EXPECT_EQ(nlohmann::json::parse(get("/api/state").body).at("live").at("frame"), nullptr);
}

TEST_F(ScreenServing, FramesOfEveryLengthArriveWhole) {
    params.live_hz = 60;
    start();
    const auto client = live_client();
    for (const size_t size : {0UL, 1UL, 124UL, 125UL, 126UL, 127UL, 65534UL, 65535UL, 65536UL, 3'000'000UL}) {
        const std::string text(size, 'x');
        server->publish(text, {});
        const auto frame = client->frame();
        ASSERT_TRUE(frame) << size;
        EXPECT_EQ(frame->payload, text) << size;
    }
}

TEST_F(ScreenServing, NobodyIsShownWhatWasPublishedBeforeHeCame) {
    start();
    server->publish("old", {});
    const auto client = live_client();
    server->publish("new", {});
    EXPECT_EQ(client->frame().value().payload, "new");
}

TEST_F(ScreenServing, NewestWinsAndTheRateIsBounded) {
    params.live_hz = 10;
    start();
    const auto client = live_client();
    const auto begin = Clock::now();
    for (int i = 0; i <= 20000; ++i) server->publish(std::to_string(i), {});
    int received = 0;
    int last = -1;
    while (last != 20000) {
        const auto frame = client->frame();
        ASSERT_TRUE(frame);
        ASSERT_EQ(frame->opcode, 1);
        EXPECT_GT(std::stoi(frame->payload), last);
        last = std::stoi(frame->payload);
        ++received;
    }
    const double passed = std::chrono::duration<double>(Clock::now() - begin).count();
    EXPECT_LE(received, 2 + 10 * passed);
}

TEST_F(ScreenServing, PingsAreAnsweredAndAGoodbyeIsReturned) {
    start();
    const auto client = live_client();
    client->send(client_frame(0x89, "are you there"));
    const auto pong = client->frame();
    ASSERT_TRUE(pong);
    EXPECT_EQ(pong->opcode, 10);
    EXPECT_EQ(pong->payload, "are you there");
    client->send(client_frame(0x8A, "unasked"));
    client->send(client_frame(0x88, std::string("\x03\xE8", 2)));
    const auto goodbye = client->frame();
    ASSERT_TRUE(goodbye);
    EXPECT_EQ(goodbye->opcode, 8);
    EXPECT_EQ(goodbye->close_code(), 1000);
    EXPECT_FALSE(client->frame());
}

TEST_F(ScreenServing, TooManyScreensAreRefusedAndTheRestIsServed) {
    params.max_live_clients = 2;
    start();
    auto first = live_client();
    const auto second = live_client();
    RawClient third(server->port());
    third.send(live_request());
    const RawAnswer answer = third.answer();
    EXPECT_EQ(answer.status, 503);
    EXPECT_EQ(answer.body,
              "{\"error\":\"As many screens as allowed are already watching; close one of them.\"}\n");
    EXPECT_EQ(get("/api/marks").status, 200);
    first->abort();
    for (const auto end = Clock::now() + seconds(10); Clock::now() < end;) {
        RawClient next(server->port());
        next.send(live_request());
        if (next.upgraded()) return;
    }
    FAIL() << "the place of the screen that left was not given away";
}

TEST_F(ScreenServing, HalfSentRequestsMakeRoomForWholeOnes) {
    params.max_connections = 4;
    params.max_live_clients = 2;
    start();
    std::vector<std::unique_ptr<RawClient>> slow;
    for (int i = 0; i < 20; ++i) {
        slow.push_back(std::make_unique<RawClient>(server->port()));
        slow.back()->send("GET / HTTP/1.1\r\nHost: loc");
        EXPECT_EQ(get("/").status, 200) << i;
    }
}

TEST_F(ScreenServing, AFullHouseSaysSo) {
    params.max_connections = 2;
    params.max_live_clients = 1;
    start();
    const auto watching = live_client();
    // An answer that is never fetched keeps its place until its time is over.
    feed.known_part = made_up_part();
    auto large = std::make_shared<ScreenPart>(*feed.known_part);
    large->mesh.vertices.resize(2'000'000, Eigen::Vector3f::Zero());
    server->stop();
    feed.known_part = large;
    start();
    const auto again = live_client();
    RawClient hoarder(server->port());
    hoarder.keep_little();
    hoarder.send(get_request("/api/part/mesh"));
    for (const auto end = Clock::now() + seconds(10); Clock::now() < end;) {
        const RawAnswer answer = get("/");
        if (answer.status == 503) {
            EXPECT_EQ(answer.body, "{\"error\":\"Too many connections are open; try again.\"}\n");
            return;
        }
    }
    FAIL() << "the third connection was never refused";
}

TEST_F(ScreenServing, ARequestThatTricklesIsToldSo) {
    params.request_timeout_ms = 100;
    start();
    RawClient client(server->port());
    client.send("GET / HT");
    const RawAnswer answer = client.answer();
    EXPECT_EQ(answer.status, 408);
    EXPECT_EQ(answer.body, "{\"error\":\"The request head did not arrive within 100 ms.\"}\n");
}

TEST_F(ScreenServing, AnAnswerThatNobodyFetchesEnds) {
    params.response_timeout_ms = 100;
    auto part = std::make_shared<ScreenPart>();
    part->mesh.vertices.resize(4'000'000, Eigen::Vector3f::Zero());
    feed.known_part = part;
    start();
    RawClient client(server->port());
    client.keep_little();
    client.send(get_request("/api/part/mesh"));
    // Reads only after the server has given up: what arrives is cut short.
    const auto patience = Clock::now() + milliseconds(400);
    while (Clock::now() < patience) EXPECT_EQ(get("/").status, 200);
    const auto all = client.read_to_end();
    EXPECT_TRUE(!all || all->size() < 48'000'000);
}

TEST_F(ScreenServing, AScreenThatTakesNothingIsDropped) {
    params.live_hz = 60;
    params.slow_client_timeout_ms = 100;
    params.max_live_clients = 1;
    start();
    const auto stuck = live_client();
    stuck->keep_little();
    // Its place becomes free although it never said goodbye.
    EXPECT_TRUE(publish_until(
        [this] {
            RawClient next(server->port());
            next.send(live_request());
            return next.upgraded();
        },
        2'000'000));
}

TEST_F(ScreenServing, ClientsThatVanishLeaveNoTrace) {
    start();
    for (int i = 0; i < 50; ++i) {
        const auto client = live_client();
        server->publish("x", std::vector<uint8_t>(100'000));
        client->abort();
        RawClient half(server->port());
        half.send("GET /api/part/mesh HTTP/1.1\r\n");
        half.abort();
    }
    EXPECT_EQ(get("/").status, 200);
}

TEST_F(ScreenServing, StoppingSaysGoodbyeAndIsQuick) {
    start();
    const auto client = live_client();
    RawClient half(server->port());
    half.send("GET / HT");
    const auto begin = Clock::now();
    server->stop();
    server->stop();
    EXPECT_LT(Clock::now() - begin, seconds(2));
    const auto goodbye = client->frame();
    ASSERT_TRUE(goodbye);
    EXPECT_EQ(goodbye->close_code(), 1001);
    EXPECT_EQ(goodbye->close_reason(), "The station is stopping.");
    EXPECT_EQ(half.read_to_end().value_or("?"), "");
    EXPECT_THROW(RawClient(server->port()), std::runtime_error);
    server->publish("into the void", {});
}

TEST_F(ScreenServing, PublishingFromSeveralThreadsWhileClientsComeAndGo) {
    params.live_hz = 60;
    start();
    std::vector<std::thread> threads;
    for (int t = 0; t < 3; ++t)
        threads.emplace_back([this] {
            for (int i = 0; i < 300; ++i) server->publish("{}", std::vector<uint8_t>(1000));
        });
    for (int i = 0; i < 30; ++i) {
        const auto client = live_client();
        EXPECT_EQ(get("/api/state").status, 200);
    }
    for (std::thread& thread : threads) thread.join();
}

TEST_F(ScreenServing, RefusesToStartWithASentence) {
    const auto sentence = [this] {
        const auto refused = ScreenServer::start(params, feed);
        return refused ? "started" : refused.error().sentence;
    };
    for (const char* host : {"0.0.0.0", "192.168.1.5", "::", "example.org", ""}) {
        params.host = host;
        EXPECT_EQ(
            sentence(),
            "screen.host '" + std::string(host) +
                "' is not a loopback address; the screen is served on 127.0.0.1, ::1 or localhost only.");
    }
    params = test_params(page);
    params.port = 65536;
    EXPECT_EQ(sentence(), "screen.port is '65536', expected 0 to 65535.");
    params = test_params(page);
    params.max_live_clients = 64;
    EXPECT_EQ(sentence(), "screen.max_live_clients is '64', expected 1 to 63.");
    params = test_params(page);
    params.live_hz = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(sentence(), "screen.live_hz is 'nan', expected 0.100000 to 60.000000.");
    params = test_params(page);
    params.web_root = "/nowhere";
    EXPECT_EQ(sentence(),
              "web_root '/nowhere' holds no index.html; build the target deixis_web or name its folder.");
    params.web_root = "";
    EXPECT_EQ(sentence(), "screen.web_root is '', expected a folder with index.html.");
}

TEST_F(ScreenServing, APortInUseIsNamed) {
    start();
    params.port = server->port();
    const auto refused = ScreenServer::start(params, feed);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().sentence,
              "Port " + std::to_string(params.port) +
                  " on 127.0.0.1 is already in use; stop the other program or choose "
                  "another screen.port.");
    server->stop();
    start();
    EXPECT_EQ(server->port(), params.port);
    EXPECT_EQ(server->address(), "http://127.0.0.1:" + std::to_string(params.port));
}

}  // namespace
}  // namespace deixis
