// Lock-step replay through real `deixis sensor` processes and stock OpenNI2: nothing lost, nothing changed,
// whatever happens to the children.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/stat.h>

#include <fstream>
#include <optional>
#include <sstream>

#include "tests/appliance/sensors/replayed.h"

namespace deixis {
namespace {

using namespace test;
using namespace std::chrono_literals;
using Outcome = FrameSource::Outcome;
using testing::HasSubstr;

/// Two sensors that do not agree on count, phase and rate.
struct TwoSensors {
    ScratchFolder folder;
    std::vector<int64_t> left = steady_stamps(150), right = steady_stamps(110, 11'000, 41'000.7);
    std::vector<SensorSpec> specs;

    TwoSensors() {
        write_recording(folder / "left.oni", left, 0);
        write_recording(folder / "right.oni", right, 1);
        specs = {recording_spec("left", folder / "left.oni"), recording_spec("right", folder / "right.oni")};
        specs[0].start_us = 1'000'000;
        specs[1].start_us = 1'004'000;
        specs[0].frames = static_cast<int64_t>(left.size());
        specs[1].frames = static_cast<int64_t>(right.size());
    }

    void expect_whole(const Replayed& replayed) const {
        EXPECT_TRUE(replayed.ended);
        ASSERT_EQ(replayed.lines.size(), left.size());
        for (size_t i = 0; i < left.size(); ++i) {
            const auto& line = replayed.lines[i];
            const int64_t stamp = left[i] + 1'000'000;
            ASSERT_EQ(line.timestamp_us, stamp);
            ASSERT_EQ(line.frames[0], std::pair(static_cast<uint32_t>(i + 1), stamp));
            size_t nearest = 0;
            for (size_t j = 1; j < right.size(); ++j)
                if (std::abs(right[j] + 1'004'000 - stamp) < std::abs(right[nearest] + 1'004'000 - stamp))
                    nearest = j;
            const int64_t partner = right[nearest] + 1'004'000;
            ASSERT_EQ(line.frames[1].has_value(), std::abs(partner - stamp) <= 17'000) << "frameset " << i;
            if (!line.frames[1]) continue;
            ASSERT_EQ(line.frames[1], std::pair(static_cast<uint32_t>(nearest + 1), partner));
        }
    }
};

TEST(ReplayProcess, DeliversEveryFrameOfTheFirstWithTheNearestOfTheSecond) {
    const TwoSensors two;
    const Replayed first = replay(two.specs), second = replay(two.specs);
    two.expect_whole(first);
    EXPECT_EQ(first.lines, second.lines);
    for (const SensorHealth& h : first.health) {
        EXPECT_EQ(h.state, SensorState::finished) << h.name << ": " << h.reason;
        EXPECT_EQ(h.dropped, 0U);
        EXPECT_EQ(h.corrupt, 0U);
        EXPECT_EQ(h.restarts, 0U);
    }
    EXPECT_EQ(first.health[0].frames, two.left.size());
}

TEST(ReplayProcess, AStationThatIsSlowLosesNothing) {
    const TwoSensors two;
    FrameSourceParams params = lock_step();
    params.ring_frames = 2;
    two.expect_whole(replay(two.specs, params, [](size_t line, FrameSource&) {
        if (line % 50 == 0) usleep(300'000);  // a station that is busy with something else
    }));
}

TEST(ReplayProcess, GoesOnExactlyWhereAKilledChildWas) {
    const TwoSensors two;
    const Replayed replayed = replay(two.specs, lock_step(), [](size_t line, FrameSource& source) {
        if (line == 20 || line == 90) kill(source.health()[0].process_id, SIGKILL);
        if (line == 50) kill(source.health()[1].process_id, SIGKILL);
    });
    two.expect_whole(replayed);
    EXPECT_GE(replayed.health[0].restarts + replayed.health[1].restarts, 2U);
}

TEST(ReplayProcess, EndsAndReplacesAChildThatHangs) {
    const TwoSensors two;
    FrameSourceParams params = lock_step();
    params.stall_limit = 300ms;
    params.ring_frames = 2;
    std::string said;
    const auto source = open_stage(two.specs, params);
    Frameset set;
    for (int i = 0; i < 10;) i += source->next(set, 100ms) == Outcome::frameset ? 1 : 0;
    kill(source->health()[0].process_id, SIGSTOP);
    within(20s, [&] {
        for (const SensorHealth& h : source->health())
            if (h.state == SensorState::restarting) said = h.reason;
        return source->next(set, 10ms) == Outcome::end;
    });
    EXPECT_THAT(said, HasSubstr("the sensor process gave no sign of life for 0."));
    EXPECT_EQ(source->health()[0].frames, two.left.size());
    EXPECT_GE(source->health()[0].restarts, 1U);
    EXPECT_EQ(source->health()[0].state, SensorState::finished) << source->health()[0].reason;
}

TEST(ReplayProcess, TwoSensorsEndApart) {
    ScratchFolder folder;
    write_recording(folder / "a.oni", steady_stamps(40), 0);
    write_recording(folder / "b.oni", steady_stamps(10), 1);
    const std::vector<SensorSpec> a_first = {recording_spec("a", folder / "a.oni"),
                                             recording_spec("b", folder / "b.oni")};
    const Replayed longer = replay(a_first);
    EXPECT_TRUE(longer.ended);
    ASSERT_EQ(longer.lines.size(), 40U);
    for (size_t i = 0; i < 40; ++i) EXPECT_EQ(longer.lines[i].frames[1].has_value(), i < 10) << i;
    expect_finished(longer);

    auto b_first = a_first;
    write_recording(folder / "b0.oni", steady_stamps(10), 0);
    write_recording(folder / "a1.oni", steady_stamps(40), 1);
    b_first[0].uri = folder / "b0.oni";
    b_first[1].uri = folder / "a1.oni";
    const Replayed shorter = replay(b_first);
    EXPECT_TRUE(shorter.ended);
    ASSERT_EQ(shorter.lines.size(), 10U);
    for (const auto& line : shorter.lines) EXPECT_TRUE(line.frames[1].has_value());
    expect_finished(shorter);
}

TEST(ReplayProcess, BothAreFoundWholeHoweverFewTheirFramesAre) {
    ScratchFolder folder;
    write_recording(folder / "a.oni", steady_stamps(3), 0);
    write_recording(folder / "b.oni", steady_stamps(3), 1);
    const std::vector<SensorSpec> specs = {recording_spec("a", folder / "a.oni"),
                                           recording_spec("b", folder / "b.oni")};
    for (int i = 0; i < 10; ++i) {  // who is the last to end is chance
        const Replayed replayed = replay(specs);
        ASSERT_EQ(replayed.lines.size(), 3U);
        expect_finished(replayed);
    }
}

TEST(ReplayProcess, AStreamWithoutDepthClocksTheFramesets) {
    ScratchFolder folder;
    write_recording(folder / "a.oni", steady_stamps(10), 0);
    write_recording(folder / "b.oni", steady_stamps(10), 1);
    FrameSourceParams params = lock_step();
    params.clock_us = {-200'000, 1'000, 17'000, 17'500, 100'000, 10'000'000};
    const Replayed replayed =
        replay({recording_spec("a", folder / "a.oni"), recording_spec("b", folder / "b.oni")}, params);
    EXPECT_TRUE(replayed.ended);
    ASSERT_EQ(replayed.lines.size(), params.clock_us.size());
    const std::vector<uint32_t> numbers = {0, 1, 2, 2, 4, 0};  // 30 Hz: frame n at (n - 1) * 33.3 ms
    for (size_t i = 0; i < numbers.size(); ++i) {
        EXPECT_EQ(replayed.lines[i].timestamp_us, params.clock_us[i]);
        for (const auto& frame : replayed.lines[i].frames)
            EXPECT_EQ(frame ? frame->first : 0, numbers[i]) << "frameset " << i;
    }
    expect_finished(replayed);
}

TEST(ReplayProcess, OneFrameAndNoFrame) {
    ScratchFolder folder;
    write_recording(folder / "one.oni", {0}, 0);
    const Replayed one = replay(std::vector{recording_spec("one", folder / "one.oni")});
    EXPECT_TRUE(one.ended);
    ASSERT_EQ(one.lines.size(), 1U);
    EXPECT_EQ(one.health[0].state, SensorState::finished);

    write_recording(folder / "none.oni", {}, 0);
    const Replayed none = replay(std::vector{recording_spec("none", folder / "none.oni")});
    EXPECT_TRUE(none.ended);
    EXPECT_EQ(none.lines.size(), 0U);
}

TEST(ReplayProcess, AShortRecordingIsNotTakenForAWholeOne) {
    ScratchFolder folder;
    write_recording(folder / "a.oni", steady_stamps(5), 0);
    auto spec = recording_spec("a", folder / "a.oni");
    spec.frames = 6;
    const Replayed replayed = replay(std::vector{spec});
    EXPECT_TRUE(replayed.ended);
    EXPECT_EQ(replayed.lines.size(), 5U);
    EXPECT_EQ(replayed.health[0].state, SensorState::missing);
    EXPECT_THAT(replayed.health[0].reason, HasSubstr("a.oni: ended after 5 frames, expected 6"));
}

TEST(ReplayProcess, PlaysAtItsOwnPaceWithoutLoss) {
    ScratchFolder folder;
    write_recording(folder / "a.oni", steady_stamps(31), 0);
    write_recording(folder / "b.oni", steady_stamps(31, 3'000), 1);
    FrameSourceParams params = lock_step();
    params.real_time = true;
    const int64_t begin = host_now_us();
    const Replayed replayed =
        replay({recording_spec("a", folder / "a.oni"), recording_spec("b", folder / "b.oni")}, params);
    EXPECT_GE(host_now_us() - begin, 1'000'000);
    ASSERT_EQ(replayed.lines.size(), 31U);
    for (const auto& line : replayed.lines) EXPECT_TRUE(line.frames[1].has_value());
}

TEST(ReplayProcess, ClosingAgainAndAgainNeverCrashes) {
    // OpenNI2's player races with close; each child opens, plays to the end and closes by itself.
    ScratchFolder folder;
    write_recording(folder / "left.oni", steady_stamps(5), 0);
    for (int i = 0; i < 25; ++i) {
        const Replayed replayed = replay(std::vector{recording_spec("left", folder / "left.oni")});
        ASSERT_EQ(replayed.lines.size(), 5U);
        ASSERT_EQ(replayed.health[0].state, SensorState::finished) << replayed.health[0].reason;
        ASSERT_EQ(replayed.health[0].restarts, 0U);
    }
}

TEST(ReplayProcess, StoppingInTheMiddleLeavesNoProcessAndNoMemory) {
    const TwoSensors two;
    std::vector<int> processes;
    for (int i = 0; i < 10; ++i) {
        const auto source = open_stage(two.specs, lock_step());
        Frameset set;
        for (int n = 0; n < i;) n += source->next(set, 100ms) == Outcome::frameset ? 1 : 0;
        for (const SensorHealth& h : source->health())
            if (h.process_id != 0) processes.push_back(h.process_id);
    }
    for (const int process : processes) EXPECT_EQ(kill(process, 0), -1) << process;
    const std::string mine = "deixis-ring-" + std::to_string(getpid()) + "-";
    for (const auto& entry : std::filesystem::directory_iterator("/dev/shm"))
        EXPECT_FALSE(entry.path().filename().string().starts_with(mine)) << entry.path();
}

/// Processor time that a process has used, in clock ticks (1/100 s).
long ticks_of(int process) {
    std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
    std::string line;
    std::getline(stat, line);
    std::istringstream fields(line.substr(line.rfind(')') + 1));
    std::string skipped;
    for (int i = 3; i <= 13; ++i) fields >> skipped;
    long user = 0, system = 0;
    fields >> user >> system;
    return user + system;
}

TEST(ReplayProcess, AfterTheLastFrameThePlayerDoesNotSpin) {
    // OpenNI2's player burns a core from the last frame of a file until it is stopped.
    ScratchFolder folder;
    write_recording(folder / "left.oni", steady_stamps(4), 0);
    FrameSourceParams params = lock_step();
    params.ring_frames = 2;
    const auto source = open_stage({recording_spec("left", folder / "left.oni")}, params);
    Frameset set;
    ASSERT_TRUE(within(20s, [&] { return source->next(set, 100ms) == Outcome::frameset; }));
    usleep(300'000);  // frames 2 and 3 lie in the ring, the child holds the last
    const int child = source->health()[0].process_id;
    const long before = ticks_of(child);
    usleep(1'000'000);
    EXPECT_LE(ticks_of(child) - before, 30);
    int more = 0;
    ASSERT_TRUE(within(20s, [&] {
        const Outcome outcome = source->next(set, 100ms);
        more += outcome == Outcome::frameset ? 1 : 0;
        return outcome == Outcome::end;
    }));
    EXPECT_EQ(more, 3);
}

TEST(ReplayProcess, RefusesWhatCannotBeAStage) {
    const auto refusal_of = [](const std::vector<SensorSpec>& specs, const FrameSourceParams& params) {
        const auto source = open_sensors(specs, params);
        return source ? std::string("opened") : source.error().sentence;
    };
    EXPECT_EQ(refusal_of({}, lock_step()), "no sensor is given, expected at least one");
    EXPECT_EQ(refusal_of({virtual_spec("left")}, lock_step()),
              "sensor \"left\" is a live device, lock-step needs recordings");
    auto spec = recording_spec("left", "left.oni");
    spec.width = 0;
    EXPECT_EQ(refusal_of({spec}, lock_step()),
              "sensor \"left\" has the size 0x120, expected sides of 1 to 8192");
    spec = recording_spec("left", "");
    EXPECT_EQ(refusal_of({spec}, lock_step()), "sensor \"left\" names no recording");
    FrameSourceParams params = lock_step();
    params.ring_frames = 1;
    EXPECT_THAT(refusal_of({recording_spec("left", "a")}, params), HasSubstr("sensors.ring_frames is 1"));
    params = lock_step();
    params.program.clear();
    EXPECT_EQ(refusal_of({recording_spec("left", "a")}, params),
              "sensors.program is \"\", expected the path of the deixis program");
}

TEST(ReplayProcess, AProgramThatIsNotThereIsAState) {
    ScratchFolder folder;
    write_recording(folder / "left.oni", steady_stamps(3), 0);
    FrameSourceParams params = lock_step();
    params.restart_delay = 1ms;
    for (const char* program : {"/no/such/deixis", "/bin/false"}) {
        params.program = program;
        const Replayed replayed = replay({recording_spec("left", folder / "left.oni")}, params);
        EXPECT_TRUE(replayed.ended);
        EXPECT_EQ(replayed.health[0].state, SensorState::missing);
        EXPECT_THAT(replayed.health[0].reason, HasSubstr("given up after 5 tries without a frame"));
    }
}

}  // namespace
}  // namespace deixis
