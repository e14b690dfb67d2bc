// What a running station prints: one line a mark, one a change of state, progress, and the figures at the
// end.
#pragma once

#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "appliance/station/station.h"

namespace deixis {

/// Prints to standard output, flushed line by line, so that whoever reads along can trust what it has read:
///   MARK <id> part_mm <x> <y> <z> zone "<zone>" arm <left|right> at_us <t>     after the commit
///   SENSOR <name> <state>: <reason>      PART <state>: <reason>      RECORD ...      PLC ...      on change
class StationLog {
  public:
    explicit StationLog(bool progress) : progress_(progress) {}

    /// After each turn.
    void tell(const Station& station, bool fresh);

    /// Framesets, dropped share, median and 99th percentile of stage_ms.total.
    void summary(const Station& station) const;

  private:
    void tell_changes(const StationState& state);
    void change(const std::string& what, const std::string& now);

    bool progress_;
    int last_percent_ = -1;
    std::map<std::string, std::string> told_;
    std::vector<float> totals_ms_;
};

}  // namespace deixis
