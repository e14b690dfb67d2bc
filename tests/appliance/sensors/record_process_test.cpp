// `deixis record` on virtual devices: bit for bit, Ctrl-C, kill -9, sensors that come and go.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>

#include <fstream>
#include <sstream>

#include "appliance/calibration/calibration_file.h"
#include "appliance/sensors/child_process.h"
#include "appliance/sessions/oni_walker.h"
#include "appliance/sessions/session.h"
#include "tests/appliance/sensors/virtual_stage.h"

namespace deixis {
namespace {

using namespace test;
using namespace std::chrono_literals;
using testing::HasSubstr;

SensorRig rig_of(const std::vector<std::string>& names) {
    SensorRig rig;
    for (const std::string& name : names) {
        CalibratedSensor sensor;
        sensor.name = name;
        sensor.uri = "virtual://" + name;
        sensor.camera.width = stage_width;
        sensor.camera.height = stage_height;
        sensor.camera.fx = sensor.camera.fy = 150;
        sensor.camera.cx = 79.5;
        sensor.camera.cy = 59.5;
        rig.sensors.push_back(sensor);
    }
    return rig;
}

class RecordProcess : public testing::Test {
  protected:
    RecordProcess() : calibration_(stage_.folder() / "calibration.toml"), out_(stage_.folder() / "session") {
        const auto written = write_calibration(rig_of({"left", "right"}), calibration_);
        EXPECT_TRUE(written) << written.error().sentence;
    }

    /// Starts `deixis record`; what it prints lands in files.
    void start(std::vector<std::string> more) {
        std::string line = "exec '" + deixis_program().string() + "' record '" + out_.string() +
                           "' --calibration '" + calibration_.string() + "' --driver-folder '" +
                           driver_folder().string() + "'";
        for (const std::string& word : more) line += " '" + word + "'";
        line += " > '" + said_in().string() + "' 2> '" + complained_in().string() + "'";
        auto child = ChildProcess::start({"/bin/sh", {"-c", line}, {}});
        ASSERT_TRUE(child) << child.error().sentence;
        record_.emplace(std::move(*child));
    }
    std::string end(std::chrono::seconds limit = 60s) {
        within(limit, [&] {
            usleep(10'000);
            return record_->ended().has_value();
        });
        return record_->ended().value_or("still runs");
    }
    static std::string text_of(const std::filesystem::path& path) {
        std::ostringstream text;
        text << std::ifstream(path).rdbuf();
        return text.str();
    }
    std::filesystem::path said_in() const { return stage_.folder() / "said"; }
    std::filesystem::path complained_in() const { return stage_.folder() / "complained"; }
    bool wait_for(const std::filesystem::path& file, const std::string& words) {
        return within(30s, [&] {
            usleep(10'000);
            return text_of(file).find(words) != std::string::npos;
        });
    }

    /// Every recorded frame is the next one that the device sent, to the bit; returns how many.
    int64_t expect_unbroken_stream(const Session& session, size_t i, bool gaps_allowed = false) {
        int64_t frames = 0, last_us = -1;
        uint32_t last = 0;
        const auto read = read_oni(session.streams[i].file, [&](int64_t, int64_t us,
                                                                const DepthImage& image) {
            const uint32_t number = image.millimetres[0];
            EXPECT_EQ(image.millimetres,
                      numbered_image(stage_width, stage_height, number, static_cast<uint32_t>(i)).millimetres)
                << "stream " << i << ", frame " << frames;
            if (frames > 0 && !gaps_allowed) {
                EXPECT_EQ(number, last % VirtualStage::frames + 1) << "stream " << i << ", frame " << frames;
                EXPECT_NEAR(static_cast<double>(us - last_us), 33'333,
                            2'000);  // 60 of 33'333.3 us a round of 2 s
            }
            last = number;
            last_us = us;
            ++frames;
            return true;
        });
        EXPECT_TRUE(read) << read.error().sentence;
        EXPECT_EQ(frames, session.streams[i].frames);
        return frames;
    }

    VirtualStage stage_;
    std::filesystem::path calibration_, out_;
    std::optional<ChildProcess> record_;
};

TEST_F(RecordProcess, KeepsTwoStreamsToTheBit) {
    start({"--seconds", "4"});
    EXPECT_EQ(end(), "ended with code 0") << text_of(complained_in());
    EXPECT_EQ(text_of(complained_in()), "");
    EXPECT_THAT(text_of(said_in()), HasSubstr("recorded " + out_.string()));
    const auto session = open_session(out_);
    ASSERT_TRUE(session) << session.error().sentence;
    ASSERT_EQ(session->streams.size(), 2U);
    for (size_t i = 0; i < 2; ++i)
        EXPECT_NEAR(static_cast<double>(expect_unbroken_stream(*session, i)), 120, 6);
    // The two clocks are 85000 s apart; on the session clock the streams are 5 ms apart.
    EXPECT_LT(std::abs(session->streams[0].start_us - session->streams[1].start_us), 60'000);
    for (const SessionStream& stream : session->streams) {
        const auto host = read_host_times(stream);
        ASSERT_TRUE(host) << host.error().sentence;
        EXPECT_EQ(static_cast<int64_t>(host->size()), stream.frames);
    }
}

TEST_F(RecordProcess, CtrlCFinishesProperly) {
    start({});
    ASSERT_TRUE(wait_for(said_in(), "recording"));
    usleep(1'000'000);  // a second of frames to keep
    kill(record_->process_id(), SIGINT);
    EXPECT_EQ(end(), "ended with code 0") << text_of(complained_in());
    const auto session = open_session(out_);
    ASSERT_TRUE(session) << session.error().sentence;
    for (size_t i = 0; i < 2; ++i) EXPECT_GE(expect_unbroken_stream(*session, i), 20);
}

TEST_F(RecordProcess, KilledRecordingIsMended) {
    start({});
    ASSERT_TRUE(wait_for(said_in(), "recording"));
    usleep(1'200'000);  // more than a second of frames to mend
    kill(record_->process_id(), SIGKILL);
    end();
    EXPECT_FALSE(std::filesystem::exists(out_));
    start({"--seconds", "1"});
    EXPECT_EQ(end(), "ended with code 1");
    EXPECT_THAT(text_of(complained_in()), HasSubstr("is an interrupted recording; mend or remove it first"));
    start({"--mend"});
    EXPECT_EQ(end(), "ended with code 0") << text_of(complained_in());
    const auto session = open_session(out_);
    ASSERT_TRUE(session) << session.error().sentence;
    for (size_t i = 0; i < 2; ++i) EXPECT_GE(expect_unbroken_stream(*session, i), 20);
}

TEST_F(RecordProcess, GoesOnWithTheOtherWhenOneIsPulled) {
    start({"--seconds", "6"});
    ASSERT_TRUE(wait_for(said_in(), "recording"));
    usleep(1'000'000);  // both record a while before one goes
    stage_.set("right", "unplugged");
    ASSERT_TRUE(wait_for(complained_in(), "sensor \"right\" is missing: virtual://right: "));
    stage_.set("right", "running");
    ASSERT_TRUE(wait_for(complained_in(), "sensor \"right\" is running"));
    EXPECT_EQ(end(), "ended with code 0") << text_of(complained_in());
    const auto session = open_session(out_);
    ASSERT_TRUE(session) << session.error().sentence;
    EXPECT_GE(expect_unbroken_stream(*session, 0), 150);
    EXPECT_GE(expect_unbroken_stream(*session, 1, true), 40);
}

TEST_F(RecordProcess, SaysWhichSensorDoesNotComeUpAndLeavesNothing) {
    stage_.set("right", "unplugged");
    start({"--wait", "5"});
    EXPECT_EQ(end(), "ended with code 1");
    EXPECT_THAT(text_of(complained_in()), HasSubstr("sensor \"right\" is missing: virtual://right: "));
    EXPECT_FALSE(std::filesystem::exists(out_));
    EXPECT_FALSE(std::filesystem::exists(out_.string() + ".recording"));
}

TEST_F(RecordProcess, RefusesWhatItCannotRecord) {
    auto rig = rig_of({"left"});
    rig.sensors[0].uri.clear();
    ASSERT_TRUE(write_calibration(rig, calibration_));
    start({"--seconds", "1"});
    EXPECT_EQ(end(), "ended with code 1");
    EXPECT_EQ(text_of(complained_in()),
              "deixis record: sensor \"left\" has no uri in the calibration, expected its live device\n");
    rig = rig_of({"left"});
    rig.sensors[0].kind = SensorKind::video;
    ASSERT_TRUE(write_calibration(rig, calibration_));
    start({"--seconds", "1"});
    EXPECT_EQ(end(), "ended with code 1");
    EXPECT_THAT(text_of(complained_in()),
                HasSubstr("is not a depth sensor, only those can be recorded live"));
    start({"--seconds", "-1"});
    EXPECT_EQ(end(), "ended with code 2");
    std::filesystem::create_directory(out_);
    start({"--seconds", "1"});
    EXPECT_EQ(end(), "ended with code 1");
    EXPECT_THAT(text_of(complained_in()), HasSubstr(out_.string()));
}

/// How many frames of a recording are not those that the device sent.
struct Judged {
    int frames = 0, altered = 0;
    std::string fault;
};

Judged judge(const std::filesystem::path& recording, uint32_t sensor) {
    Judged judged;
    const auto read = read_oni(recording, [&](int64_t, int64_t, const DepthImage& image) {
        const DepthImage sent = numbered_image(stage_width, stage_height,
                                               image.millimetres[0] % (VirtualStage::frames + 1), sensor);
        ++judged.frames;
        judged.altered += image.millimetres == sent.millimetres ? 0 : 1;
        return true;
    });
    if (!read) judged.fault = read.error().sentence;
    return judged;
}

TEST_F(RecordProcess, IsRightWhereTwoStockRecordersInOneProcessMayNotBe) {
    // Both watch the same devices at the same time. The stock Recorder is only reported: it is not always
    // wrong.
    const auto peer_folder = stage_.folder() / "peer";
    std::filesystem::create_directory(peer_folder);
    auto peer = ChildProcess::start(
        {std::filesystem::read_symlink("/proc/self/exe").parent_path() / "stock_recorder_peer",
         {peer_folder, "6"},
         {{"LD_LIBRARY_PATH", driver_folder()}}});
    ASSERT_TRUE(peer) << peer.error().sentence;
    start({"--seconds", "4"});
    EXPECT_EQ(end(), "ended with code 0") << text_of(complained_in());
    ASSERT_TRUE(within(30s, [&] { return peer->ended().has_value(); }));
    std::cout << "the peer " << *peer->ended() << '\n';
    const auto session = open_session(out_);
    ASSERT_TRUE(session) << session.error().sentence;
    for (size_t i = 0; i < 2; ++i) {
        const Judged ours = judge(session->streams[i].file, static_cast<uint32_t>(i));
        EXPECT_EQ(ours.fault, "");
        EXPECT_GE(ours.frames, 100);
        EXPECT_EQ(ours.altered, 0);
        (void)mend_recording(peer_folder / (session->streams[i].sensor + ".oni"));
        const Judged stock =
            judge(peer_folder / (session->streams[i].sensor + ".oni"), static_cast<uint32_t>(i));
        std::cout << "stock Recorder, " << session->streams[i].sensor << ": " << stock.altered << " of "
                  << stock.frames << " frames altered; " << stock.fault << '\n';
    }
}

}  // namespace
}  // namespace deixis
