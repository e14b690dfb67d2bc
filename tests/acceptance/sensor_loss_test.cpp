// `kill -9` and SIGSTOP of a sensor child while the station runs: the station goes on, says so in the state
// that it publishes to the screen, and recovers; it ends as usual with every frame and the same marks.
#include <Poco/Net/HTTPClientSession.h>
#include <Poco/Net/HTTPRequest.h>
#include <Poco/Net/HTTPResponse.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "appliance/calibration/calibration_file.h"
#include "tests/acceptance/watched_program.h"

namespace deixis {
namespace {

using Clock = std::chrono::steady_clock;

/// What the station publishes now, from its screen's own door.
nlohmann::json published_state(const std::string& address) {
    const size_t colon = address.rfind(':');
    Poco::Net::HTTPClientSession door("127.0.0.1",
                                      static_cast<Poco::UInt16>(std::stoi(address.substr(colon + 1))));
    Poco::Net::HTTPRequest request(Poco::Net::HTTPRequest::HTTP_GET, "/api/state",
                                   Poco::Net::HTTPMessage::HTTP_1_1);
    door.sendRequest(request);
    Poco::Net::HTTPResponse response;
    std::istream& body = door.receiveResponse(response);
    const nlohmann::json answer = nlohmann::json::parse(body, nullptr, false);
    return answer.contains("live") ? answer["live"] : answer;
}

std::string sensor_state(const nlohmann::json& state, const std::string& name) {
    if (!state.contains("sensors")) return "";
    for (const auto& sensor : state["sensors"]) {
        if (sensor["name"] == name) return sensor["state"];
    }
    return "";
}

int64_t stamp_of(const nlohmann::json& state) {
    if (!state.contains("frame") || !state["frame"].is_object()) return -1;
    return state["frame"].value("timestamp_us", int64_t{-1});
}

/// Polls the published state until `wanted` holds; the state then, or null when it never does.
template <class Wanted>
nlohmann::json wait_for_state(const std::string& address, std::chrono::seconds patience, Wanted wanted) {
    const auto deadline = Clock::now() + patience;
    while (Clock::now() < deadline) {
        nlohmann::json state = published_state(address);
        if (wanted(state)) return state;
        // A real process is waited for; it publishes at its own pace.
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return nullptr;
}

struct Loss {
    const char* sensor;
    const char* other;
    int signal;
};

/// A live station on two virtual sensors that send the session's frames over and over.
class SensorLoss : public testing::TestWithParam<Loss> {
  protected:
    void SetUp() override {
        const char* session = std::getenv("DEIXIS_SESSION");
        const char* bin = std::getenv("DEIXIS_BIN");
        ASSERT_TRUE(session != nullptr && bin != nullptr);
        folder_ = testing::TempDir() + "/sensor_loss";
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        auto calibration = read_calibration(std::filesystem::path(session) / "calibration.toml");
        ASSERT_TRUE(calibration) << calibration.error().sentence;
        for (CalibratedSensor& sensor : calibration->rig.sensors) sensor.uri = "virtual://" + sensor.name;
        ASSERT_TRUE(write_calibration(calibration->rig, folder_ + "/calibration.toml"));
        setenv("DEIXIS_VIRTUAL_SENSORS", session, 1);
        station_.emplace(std::vector<std::string>{
            "deixis", "station", "--calibration", folder_ + "/calibration.toml", "--part",
            std::string(session) + "/part.toml", "--background", std::string(session) + "/background",
            "--driver-folder", std::string(bin) + "/../lib", "--database", folder_ + "/record.db",
            "--screen-port", "0"});
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string folder_;
    std::optional<WatchedProgram> station_;
};

TEST_P(SensorLoss, IsPublishedAndOutlived) {
    const Loss loss = GetParam();
    const auto is_running = [&](const nlohmann::json& state) {
        return sensor_state(state, loss.sensor) == "running" && sensor_state(state, loss.other) == "running";
    };
    const auto screen = station_->wait_for(
        [](const std::string& line) { return line.starts_with("SCREEN "); }, std::chrono::seconds(120));
    ASSERT_TRUE(screen) << testing::PrintToString(station_->lines());
    const std::string address = screen->substr(7, screen->find_last_not_of("/ ") - 6);
    const auto running = wait_for_state(address, std::chrono::seconds(60), [&](const nlohmann::json& state) {
        return is_running(state) && stamp_of(state) >= 0;
    });
    ASSERT_FALSE(running.is_null()) << "the station never ran";

    const std::string uri = std::string("virtual://") + loss.sensor;
    const std::vector<pid_t> before = station_->children_with(uri);
    ASSERT_EQ(before.size(), 1U);
    ASSERT_EQ(kill(before[0], loss.signal), 0);
    const auto told = wait_for_state(address, std::chrono::seconds(20), [&](const nlohmann::json& state) {
        const std::string now = sensor_state(state, loss.sensor);
        return now != "running" && !now.empty();
    });
    ASSERT_FALSE(told.is_null()) << "the loss was never published";
    EXPECT_THAT(sensor_state(told, loss.sensor),
                testing::AnyOf("stalled", "restarting", "starting", "missing"));
    EXPECT_EQ(sensor_state(told, loss.other), "running");

    bool went_on = false;  // with the other eye alone
    const auto recovered =
        wait_for_state(address, std::chrono::seconds(30), [&](const nlohmann::json& state) {
            const bool newer = stamp_of(state) > stamp_of(told);
            went_on = went_on || (newer && !is_running(state));
            return newer && is_running(state);
        });
    ASSERT_FALSE(recovered.is_null()) << "the sensor did not come back: " << published_state(address).dump();
    EXPECT_TRUE(went_on) << "no frame came while the sensor was away";
    const std::vector<pid_t> after = station_->children_with(uri);
    ASSERT_EQ(after.size(), 1U);
    EXPECT_NE(after[0], before[0]);

    station_->send(SIGTERM);
    EXPECT_EQ(station_->wait(), 0) << testing::PrintToString(station_->lines());
    const std::string lost = std::string("SENSOR ") + loss.sensor + " restarting";
    EXPECT_THAT(station_->lines(), testing::Contains(testing::StartsWith(lost)));
}

INSTANTIATE_TEST_SUITE_P(BySensorAndSignal, SensorLoss,
                         testing::Values(Loss{"left", "right", SIGKILL}, Loss{"right", "left", SIGKILL},
                                         Loss{"left", "right", SIGSTOP}, Loss{"right", "left", SIGSTOP}),
                         [](const auto& loss) {
                             return std::string(loss.param.sensor) +
                                    (loss.param.signal == SIGKILL ? "_killed" : "_stopped");
                         });

}  // namespace
}  // namespace deixis
