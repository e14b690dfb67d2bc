// Two virtual devices whose behaviour a test changes while they run.
#pragma once

#include <cstdlib>
#include <fstream>
#include <map>

#include "tests/appliance/sensors/sensor_stage.h"

namespace deixis::test {

/// Devices virtual://left and virtual://right, 60 numbered frames each, in step but for 5 ms, with clocks of
/// their own.
class VirtualStage {
  public:
    static constexpr int frames = 60;

    VirtualStage() {
        write_recording(folder_ / "left.oni", steady_stamps(frames), 0);
        write_recording(folder_ / "right.oni", steady_stamps(frames), 1);
        lines_["left"] = "recording = \"left.oni\"\nclock_offset_us = 5000000000\nperiod_us = 2000000\n";
        lines_["right"] =
            "recording = \"right.oni\"\nclock_offset_us = 90000000000\nperiod_us = 2000000\nstart_us = "
            "5000\n";
        states_ = {{"left", "running"}, {"right", "running"}};
        write();
        setenv("DEIXIS_VIRTUAL_SENSORS", (folder_ / "plan.toml").c_str(), 1);
    }
    ~VirtualStage() { unsetenv("DEIXIS_VIRTUAL_SENSORS"); }

    void set(const std::string& sensor, const std::string& state) {
        states_[sensor] = state;
        write();
    }
    const ScratchFolder& folder() const { return folder_; }

  private:
    void write() {
        {
            std::ofstream file(folder_ / "plan.new");
            for (const auto& [name, line] : lines_)
                file << "[" << name << "]\n" << line << "state = \"" << states_[name] << "\"\n";
        }
        std::filesystem::rename(folder_ / "plan.new", folder_ / "plan.toml");
    }

    ScratchFolder folder_;
    std::map<std::string, std::string> lines_, states_;
};

}  // namespace deixis::test
