// The station: framesets in, acknowledged marks out. Wires sensors, perception, record and PLC; one turn a
// frameset.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <vector>

#include "appliance/station/settings.h"
#include "appliance/station/station_state.h"
#include "appliance/station/work_cell.h"

namespace deixis {

struct StationSetup {
    WorkCell cell;
    Settings settings;
    std::filesystem::path database;       ///< made where there is none
    std::filesystem::path program;        ///< the `deixis` binary, for the sensor children
    std::filesystem::path driver_folder;  ///< private OpenNI2 folder; empty: the system's
    bool lock_step = false;  ///< recordings: drop nothing, commit each mark on its own frame, ask no clock
    bool real_time = false;  ///< recordings at their own pace
    bool plc = true;         ///< false: whatever the settings say, no PLC is talked to
};

/// Which part stands in the cell: as part.toml says, until the PLC names one; then what the PLC says.
struct PartInCell {
    std::string type;
    std::string serial;     ///< empty: not known
    uint16_t sequence = 0;  ///< the PLC's number for it; 0 = the PLC has named none, or has taken it away
};

/// Belongs to one thread. Lock-step: results depend on the session and the settings alone. Live: a mark is
/// queued for the disk and appears in the result of the frame by which it was committed; nothing is
/// acknowledged before.
class Station {
  public:
    enum class Turn { frame, waiting, finished };

    /// Refuses a database that does not open, a PLC port that is taken, bad parameters: one sentence each.
    static Result<std::unique_ptr<Station>> start(StationSetup setup);
    ~Station();

    /// Waits at most `patience` for a frameset and works on it. `waiting`: none came, `state()` says what is
    /// missing. `finished`: the recordings are played. On every turn commits and echoes are collected.
    Turn turn(std::chrono::milliseconds patience);

    /// Of the last turn that returned `frame`.
    const FrameResult& result() const;

    /// Marks acknowledged during the last turn, as they stand in the record: sound, screen and PLC may tell
    /// now.
    const std::vector<DefectRecord>& acknowledged() const;

    const PartInCell& part() const;

    StationState state() const;
    void worker_voxels(std::vector<Eigen::Vector3f>& centres) const;
    float voxel_size() const;

    /// Writes what waits for the disk; returns the sentences of what could not be kept.
    std::vector<std::string> stop();

  private:
    struct Impl;
    explicit Station(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace deixis
