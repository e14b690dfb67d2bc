// What station and link thread share: the newest state, the defects on their way, what the PLC last said.
#pragma once

#include <chrono>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "appliance/plc/plc_link.h"

namespace deixis {

/// Threads: all members from any thread; each holds the lock for a few copies only.
class LinkBoard {
  public:
    using Clock = std::chrono::steady_clock;

    explicit LinkBoard(const PlcParams& params);

    // The station's side: as PlcLink.
    void publish(const PlcOutputs& outputs);
    Result<void> deliver(const PlcDefect& defect);
    std::vector<DefectId> take_echoed();
    PlcInputs inputs() const;
    LinkState state() const;
    std::vector<std::string> take_log();

    // The link thread's side.
    ToPlcWords words_for_plc();
    /// Takes echo, heartbeat and part from the PLC's block.
    void read_from_plc(const FromPlcWords& words);
    void set_connections(int connections, const std::string& reason_if_none);
    void count_request();
    /// Counts a refusal and keeps its sentence.
    void refuse(std::string sentence);
    void log(std::string sentence);

  private:
    bool heard(Clock::time_point now) const;
    void stand_next();
    void keep(std::string sentence);

    const PlcParams params_;
    mutable std::mutex mutex_;
    PlcOutputs outputs_;
    uint16_t heartbeat_ = 0;
    Clock::time_point published_at_;
    bool published_ = false;

    std::deque<PlcDefect> defects_;  ///< the first one stands
    uint16_t standing_sequence_ = 0;
    std::vector<DefectId> echoed_;

    PlcInputs inputs_;
    bool plc_spoke_ = false;
    bool plc_beats_ = false;  ///< its heartbeat has changed at least once
    Clock::time_point plc_beat_at_;

    int connections_ = 0;
    std::string reason_;
    uint64_t requests_ = 0, refused_ = 0, echoed_count_ = 0;
    std::deque<std::string> log_;
};

}  // namespace deixis
