// Joins station and screen: answers the server's questions from memory and publishes the live stream.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "appliance/station/station.h"
#include "hmi/server/screen_server.h"

namespace deixis {

/// `show` and `acknowledge` belong to the station's thread; the server asks from its own.
class ScreenLink : public ScreenFeed {
  public:
    /// Starts the server. Refuses what `ScreenServer::start` refuses.
    static Result<std::unique_ptr<ScreenLink>> start(const ScreenServerParams& params, const WorkCell& cell,
                                                     const std::filesystem::path& database);

    /// After each turn: the state, the frame if there was one, and the marks acknowledged in it.
    void show(const Station& station, bool fresh);

    std::string address() const { return server_->address(); }

    std::shared_ptr<const ScreenPart> part() override;
    std::shared_ptr<const SensorRig> rig() override;
    Result<std::string> marks_json() override;

  private:
    ScreenLink() = default;
    void load_marks();

    std::filesystem::path database_;
    std::chrono::steady_clock::time_point last_;
    std::vector<Eigen::Vector3f> voxels_;
    std::mutex mutex_;  ///< guards the three below
    std::shared_ptr<const ScreenPart> part_;
    std::shared_ptr<const SensorRig> rig_;
    std::vector<DefectRecord> marks_;
    std::optional<Failure> unreadable_;     ///< why the marks of the part are not known
    std::unique_ptr<ScreenServer> server_;  ///< last: it asks until it is gone
};

}  // namespace deixis
