// The live message: sensors, record, PLC, progress; no frame means null, not the last one.
#include "appliance/station/station_state.h"

#include <gtest/gtest.h>

namespace deixis {
namespace {

StationState two_sensors() {
    StationState state;
    state.source = "demo";
    for (const char* name : {"left", "right"}) {
        SensorHealth sensor;
        sensor.name = name;
        sensor.state = SensorState::running;
        sensor.age_us = 12'000;
        state.sensors.push_back(sensor);
    }
    return state;
}

TEST(StationState, NoFrameIsNull) {
    const auto message = live_message(two_sensors(), nullptr);
    EXPECT_TRUE(message["frame"].is_null());
    EXPECT_TRUE(message["progress"].is_null()) << "live has no end";
    EXPECT_EQ(message["stale_after_ms"], 1000);
    EXPECT_EQ(message["plc"]["state"], "off");
}

TEST(StationState, SensorsSpeakForThemselves) {
    StationState state = two_sensors();
    EXPECT_TRUE(sensors_ok(state));
    state.sensors[1].state = SensorState::stalled;
    state.sensors[1].reason = "no heartbeat for 1200 ms";
    state.sensors[0].age_us = -1;
    EXPECT_FALSE(sensors_ok(state));
    const auto message = live_message(state, nullptr);
    EXPECT_EQ(message["sensors"][1]["state"], "stalled");
    EXPECT_EQ(message["sensors"][1]["reason"], "no heartbeat for 1200 ms");
    EXPECT_EQ(message["sensors"][1]["age_ms"], 12);
    EXPECT_TRUE(message["sensors"][0]["age_ms"].is_null());
}

TEST(StationState, ProgressIsAShare) {
    StationState state = two_sensors();
    state.framesets = 50;
    state.expected = 200;
    const FrameResult frame;
    const auto message = live_message(state, &frame);
    EXPECT_EQ(message["progress"], 0.25);
    EXPECT_EQ(message["frame"]["timestamp_us"], 0);
}

}  // namespace
}  // namespace deixis
