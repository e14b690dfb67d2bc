// Live sensors through the real OpenNI2 driver interface: pairing, loss of either eye, recovery,
// misbehaviour.
#include <gmock/gmock.h>
#include <signal.h>

#include "appliance/sensors/frame_source.h"
#include "tests/appliance/sensors/virtual_stage.h"

namespace deixis {
namespace {

using namespace test;
using namespace std::chrono_literals;
using Outcome = FrameSource::Outcome;
using testing::HasSubstr;

/// Two live sensors and what came from them.
class LiveProcess : public testing::Test {
  protected:
    void open(FrameSourceParams params = stage_params(), const std::string& second = "right") {
        source_ = open_stage({virtual_spec("left"), virtual_spec(second)}, params);
        ASSERT_TRUE(source_);
    }

    /// Takes framesets until `enough` holds; each is checked.
    bool run_until(const std::function<bool()>& enough, std::chrono::seconds limit = 20s) {
        return within(limit, [&] {
            if (source_->next(set_, 20ms) == Outcome::frameset) check();
            return enough();
        });
    }
    bool run_framesets(int count) {
        const int goal = framesets_ + count;
        return run_until([&] { return framesets_ >= goal; });
    }

    void check() {
        ++framesets_;
        EXPECT_GT(set_.timestamp_us, last_stamp_us_);
        last_stamp_us_ = set_.timestamp_us;
        EXPECT_NEAR(static_cast<double>(set_.timestamp_us), static_cast<double>(host_now_us()), 5e6);
        for (size_t s = 0; s < 2; ++s) {
            const DepthFrame& frame = set_.frames[s];
            if (!frame.present) continue;
            const uint32_t number = frame.depth.millimetres[0];
            EXPECT_GE(number, 1U);
            EXPECT_LE(number, static_cast<uint32_t>(VirtualStage::frames));
            EXPECT_EQ(
                frame.depth.millimetres,
                numbered_image(stage_width, stage_height, number, static_cast<uint32_t>(s)).millimetres);
            EXPECT_LE(std::abs(frame.timestamp_us - set_.timestamp_us), 17'000);
        }
        if (set_.frames[0].present && set_.frames[1].present) {
            ++pairs_;
            if (set_.frames[0].depth.millimetres[0] == set_.frames[1].depth.millimetres[0]) ++true_pairs_;
        }
        if (!set_.frames[0].present) ++without_first_;
        if (!set_.frames[1].present) ++without_second_;
    }

    SensorHealth health(size_t i) const { return source_->health()[i]; }
    bool both_run() const {
        return health(0).state == SensorState::running && health(1).state == SensorState::running &&
               set_.frames.size() == 2 && set_.frames[0].present && set_.frames[1].present;
    }
    void expect_recovery() {
        EXPECT_TRUE(run_until([&] { return both_run(); })) << health(0).reason << "; " << health(1).reason;
        const int pairs = pairs_;
        EXPECT_TRUE(run_until([&] { return pairs_ >= pairs + 10; }));
    }

    VirtualStage stage_;
    std::unique_ptr<FrameSource> source_;
    Frameset set_;
    int64_t last_stamp_us_ = INT64_MIN;
    int framesets_ = 0, pairs_ = 0, true_pairs_ = 0, without_first_ = 0, without_second_ = 0;
};

TEST_F(LiveProcess, PairsTwoSensorsWhoseClocksDisagree) {
    open();
    ASSERT_TRUE(run_until([&] { return both_run(); })) << health(0).reason << "; " << health(1).reason;
    ASSERT_TRUE(run_framesets(15));  // clocks settle
    pairs_ = true_pairs_ = framesets_ = 0;
    ASSERT_TRUE(run_framesets(60));
    EXPECT_GE(pairs_, framesets_ * 8 / 10);
    EXPECT_EQ(pairs_, true_pairs_) << "frames of different moments were paired";
    EXPECT_NEAR(static_cast<double>(health(1).clock_offset_us), -90e9, 1e6);
    EXPECT_NEAR(static_cast<double>(health(0).clock_offset_us), -5e9, 1e6);
    EXPECT_EQ(health(0).skew_us, 0);
    EXPECT_NEAR(static_cast<double>(health(1).skew_us), 5'000, 5'000);
}

TEST_F(LiveProcess, SecondSensorUnpluggedAndBack) {
    open();
    expect_recovery();
    stage_.set("right", "unplugged");
    ASSERT_TRUE(run_until([&] { return health(1).state == SensorState::missing; }));
    EXPECT_THAT(health(1).reason, HasSubstr("virtual://right: "));
    const int before = framesets_;
    EXPECT_TRUE(run_framesets(20)) << "the other eye was held up";
    EXPECT_GE(without_second_, 15) << before;
    EXPECT_EQ(health(0).state, SensorState::running);
    stage_.set("right", "running");
    expect_recovery();
    EXPECT_GE(health(1).restarts, 1U);
}

TEST_F(LiveProcess, FirstSensorUnpluggedAndBack) {
    open();
    expect_recovery();
    stage_.set("left", "unplugged");
    ASSERT_TRUE(run_until([&] { return health(0).state == SensorState::missing && without_first_ >= 20; }));
    EXPECT_THAT(health(0).reason, HasSubstr("virtual://left: "));
    EXPECT_TRUE(set_.frames[1].present);
    stage_.set("left", "running");
    expect_recovery();
}

TEST_F(LiveProcess, ChildKilled) {
    open();
    expect_recovery();
    for (size_t i = 0; i < 2; ++i) {
        const int victim = health(i).process_id;
        std::string said;
        ASSERT_EQ(kill(victim, SIGKILL), 0);
        ASSERT_TRUE(run_until([&] {
            const SensorHealth h = health(i);
            if (h.state == SensorState::restarting) said = h.reason;
            return !said.empty();
        }));
        EXPECT_EQ(said, "the sensor process was killed by signal 9 (Killed)");
        expect_recovery();
        EXPECT_NE(health(i).process_id, victim);
    }
}

TEST_F(LiveProcess, ChildStopped) {
    open();
    expect_recovery();
    std::string said;
    const int framesets = framesets_;
    ASSERT_EQ(kill(health(0).process_id, SIGSTOP), 0);
    ASSERT_TRUE(run_until([&] {
        const SensorHealth h = health(0);
        if (h.state == SensorState::restarting) said = h.reason;
        return !said.empty();
    }));
    EXPECT_THAT(said, HasSubstr("the sensor process gave no sign of life for 1."));
    EXPECT_GE(framesets_ - framesets, 10) << "the station stood still while a child hung";
    expect_recovery();
}

TEST_F(LiveProcess, SilentDeviceIsStalledNotRunning) {
    open();
    expect_recovery();
    stage_.set("left", "silent");
    ASSERT_TRUE(run_until([&] { return health(0).state == SensorState::stalled; }));
    EXPECT_THAT(health(0).reason, HasSubstr("no frame for 1."));
    EXPECT_GE(without_first_, 10);
    stage_.set("left", "running");
    expect_recovery();
}

TEST_F(LiveProcess, DeviceSilentForLongIsOpenedAnew) {
    open();
    expect_recovery();
    stage_.set("right", "silent");
    ASSERT_TRUE(run_until([&] { return health(1).reason == "virtual://right: has sent no frame for 5 s"; }));
    EXPECT_EQ(health(1).state, SensorState::missing);
    stage_.set("right", "running");
    expect_recovery();
}

TEST_F(LiveProcess, OtherResolutionIsRefusedByName) {
    open();
    expect_recovery();
    stage_.set("left", "small");
    ASSERT_TRUE(run_until([&] { return health(0).state == SensorState::missing; }));
    EXPECT_EQ(health(0).reason, "virtual://left: sends 80x60, expected 160x120");
    stage_.set("left", "running");
    expect_recovery();
}

TEST_F(LiveProcess, ForbiddenPixelsAreRefusedByName) {
    open();
    expect_recovery();
    stage_.set("right", "garbage");
    std::string said;
    ASSERT_TRUE(run_until([&] {
        const SensorHealth h = health(1);
        if (h.state == SensorState::restarting) said = h.reason;
        return !said.empty();
    }));
    EXPECT_THAT(said, HasSubstr("holds the value 65535, which is not a depth"));
    EXPECT_GE(health(1).corrupt, 3U);
    stage_.set("right", "running");
    expect_recovery();
}

TEST_F(LiveProcess, ClockRunningBackwardsIsRefusedByName) {
    open();
    expect_recovery();
    stage_.set("right", "backwards");
    std::string said;
    ASSERT_TRUE(run_until([&] {
        const SensorHealth h = health(1);
        if (h.state == SensorState::restarting) said = h.reason;
        return !said.empty();
    }));
    EXPECT_THAT(said, HasSubstr("time runs backwards"));
    stage_.set("right", "running");
    expect_recovery();
}

TEST_F(LiveProcess, DeviceThatHangsInOpenDoesNotHoldUpTheOther) {
    stage_.set("left", "stuck");
    FrameSourceParams params = stage_params();
    params.start_limit = 4s;  // a loaded machine needs 2 s to load the program
    open(params);
    std::string said;
    ASSERT_TRUE(run_until(
        [&] {
            const SensorHealth h = health(0);
            if (h.state == SensorState::restarting) said = h.reason;
            return !said.empty() && without_first_ >= 10;
        },
        40s));
    EXPECT_THAT(said, HasSubstr("the sensor process gave no sign of life for 4."));
    stage_.set("left", "running");
    expect_recovery();
}

TEST_F(LiveProcess, NoSuchDevice) {
    open(stage_params(), "nobody");
    ASSERT_TRUE(run_until([&] { return health(1).state == SensorState::missing && without_second_ >= 10; }));
    EXPECT_THAT(health(1).reason, HasSubstr("virtual://nobody: cannot be opened: "));
    EXPECT_EQ(health(1).reason.find('\n'), std::string::npos);
}

TEST_F(LiveProcess, NoDeviceAtAll) {
    FrameSourceParams params = stage_params();
    stage_.set("left", "unplugged");
    stage_.set("right", "unplugged");
    SensorSpec any = virtual_spec("left");
    any.uri = "any";
    source_ = open_stage({any}, params);
    ASSERT_TRUE(run_until([&] { return health(0).state == SensorState::missing; }));
    EXPECT_THAT(health(0).reason, HasSubstr("any: cannot be opened: "));
    EXPECT_EQ(source_->next(set_, 10ms), Outcome::timeout);
}

TEST_F(LiveProcess, DeviceOfAnotherSizeThanCalibrated) {
    SensorSpec spec = virtual_spec("left");
    spec.width = 640;
    spec.height = 480;
    source_ = open_stage({spec}, stage_params());
    ASSERT_TRUE(run_until([&] { return health(0).state == SensorState::missing; }));
    EXPECT_EQ(health(0).reason, "virtual://left: offers no depth of 640x480 in millimetres");
}

TEST_F(LiveProcess, SlowStationGetsTheNewestFramesAndIsToldWhatItMissed) {
    open();
    expect_recovery();
    for (int i = 0; i < 5; ++i) {
        usleep(600'000);  // a station busy for 18 frames
        ASSERT_TRUE(run_framesets(1));
        EXPECT_LT(host_now_us() - set_.timestamp_us, 300'000) << "an old frame was shown";
    }
    EXPECT_GE(health(0).dropped, 40U);
    EXPECT_EQ(health(0).corrupt, 0U);
}

TEST_F(LiveProcess, UnpluggedAgainAndAgain) {
    FrameSourceParams params = stage_params();
    params.restart_delay = 10ms;
    open(params);
    expect_recovery();
    for (int i = 0; i < 10; ++i) {
        stage_.set("right", "unplugged");
        ASSERT_TRUE(run_until([&] { return health(1).state == SensorState::missing; })) << i;
        stage_.set("right", "running");
        ASSERT_TRUE(run_until([&] { return both_run(); })) << i << ": " << health(1).reason;
    }
    EXPECT_EQ(health(0).restarts, 0U);
}

TEST(PacedRecordings, PlayLiveSideBySide) {
    ScratchFolder folder;
    write_recording(folder / "a.oni", steady_stamps(60), 0);
    write_recording(folder / "b.oni", steady_stamps(60, 4'000), 1);
    const auto source = open_stage(
        {recording_spec("a", folder / "a.oni"), recording_spec("b", folder / "b.oni")}, stage_params());
    Frameset set;
    int framesets = 0, pairs = 0;
    const int64_t begin = host_now_us();
    ASSERT_TRUE(within(20s, [&] {
        const Outcome outcome = source->next(set, 50ms);
        if (outcome == Outcome::frameset) {
            ++framesets;
            pairs += set.frames[0].present && set.frames[1].present ? 1 : 0;
        }
        return outcome == Outcome::end;
    }));
    EXPECT_GE(host_now_us() - begin, 1'900'000);
    EXPECT_GE(framesets, 50);
    EXPECT_GE(pairs, framesets * 8 / 10);
    EXPECT_EQ(source->health()[0].state, SensorState::finished);
}

}  // namespace
}  // namespace deixis
