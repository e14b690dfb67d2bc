// One lock, short sections; the rules of heartbeat, part and echo live here for both modes.
#include "appliance/plc/link_board.h"

#include <algorithm>
#include <utility>

namespace deixis {

using std::chrono::milliseconds;

LinkBoard::LinkBoard(const PlcParams& params) : params_(params) {}

void LinkBoard::publish(const PlcOutputs& outputs) {
    const std::lock_guard lock(mutex_);
    outputs_ = outputs;
    ++heartbeat_;
    published_ = true;
    published_at_ = Clock::now();
}

Result<void> LinkBoard::deliver(const PlcDefect& defect) {
    const std::lock_guard lock(mutex_);
    const auto same = [&](const PlcDefect& other) { return other.id == defect.id; };
    if (std::any_of(defects_.begin(), defects_.end(), same)) return {};
    if (defects_.size() >= static_cast<size_t>(params_.queue_length))
        return fail("defect " + std::to_string(defect.id) +
                    " is not queued for the PLC: " + std::to_string(defects_.size()) +
                    " already wait for its echo; the record keeps it as undelivered");
    defects_.push_back(defect);
    if (defects_.size() == 1) stand_next();
    return {};
}

void LinkBoard::stand_next() {
    standing_sequence_ = defects_.empty() ? 0 : sequence_of(defects_.front().id, inputs_.echo_sequence);
}

std::vector<DefectId> LinkBoard::take_echoed() {
    const std::lock_guard lock(mutex_);
    return std::exchange(echoed_, {});
}

PlcInputs LinkBoard::inputs() const {
    const std::lock_guard lock(mutex_);
    return inputs_;
}

std::vector<std::string> LinkBoard::take_log() {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> sentences(log_.begin(), log_.end());
    log_.clear();
    return sentences;
}

bool LinkBoard::heard(Clock::time_point now) const {
    return plc_beats_ && now - plc_beat_at_ < milliseconds(params_.heartbeat_timeout_ms);
}

LinkState LinkBoard::state() const {
    const std::lock_guard lock(mutex_);
    LinkState state;
    state.connections = connections_;
    state.defects_waiting = static_cast<int>(defects_.size());
    state.requests = requests_;
    state.refused = refused_;
    state.defects_echoed = echoed_count_;
    if (connections_ == 0) {
        state.phase = LinkPhase::waiting;
        state.reason = reason_;
    } else if (!heard(Clock::now())) {
        state.phase = LinkPhase::connected;
        state.reason =
            "the PLC is connected but its heartbeat stands still; let it change the register plc_heartbeat";
    } else {
        state.phase = LinkPhase::alive;
    }
    return state;
}

ToPlcWords LinkBoard::words_for_plc() {
    const std::lock_guard lock(mutex_);
    const auto now = Clock::now();
    LinkWords link;
    link.heartbeat = heartbeat_;
    link.defects_waiting = static_cast<uint16_t>(std::min<size_t>(defects_.size(), 65535));
    link.defect_sequence = standing_sequence_;
    link.plc_heard = heard(now);
    link.station_alive = published_ && now - published_at_ < milliseconds(params_.stale_ms);
    std::optional<PlcDefect> standing;
    if (!defects_.empty()) standing = defects_.front();
    return to_words(outputs_, standing, link);
}

void LinkBoard::read_from_plc(const FromPlcWords& words) {
    const PlcInputs said = from_words(words);
    const std::lock_guard lock(mutex_);
    if (plc_spoke_ && said.heartbeat != inputs_.heartbeat) {
        plc_beats_ = true;
        plc_beat_at_ = Clock::now();
    }
    const bool first_word = !std::exchange(plc_spoke_, true);
    inputs_.heartbeat = said.heartbeat;
    inputs_.echo_sequence = said.echo_sequence;
    // Type and serial count only together with a new part_sequence: a PLC may write them one by one.
    if (said.part_sequence != inputs_.part_sequence) {
        inputs_.part_sequence = said.part_sequence;
        inputs_.part_type = said.part_sequence == 0 ? std::string() : said.part_type;
        inputs_.part_serial = said.part_sequence == 0 ? std::string() : said.part_serial;
    }
    // What the PLC shows at first may be left over from an earlier record: no echo, but a number to avoid.
    if (first_word) stand_next();
    if (defects_.empty() || said.echo_sequence != standing_sequence_) return;
    echoed_.push_back(defects_.front().id);
    ++echoed_count_;
    defects_.pop_front();
    stand_next();
}

void LinkBoard::set_connections(int connections, const std::string& reason_if_none) {
    const std::lock_guard lock(mutex_);
    connections_ = connections;
    reason_ = reason_if_none;
    if (connections == 0) plc_beats_ = false;
}

void LinkBoard::count_request() {
    const std::lock_guard lock(mutex_);
    ++requests_;
}

void LinkBoard::refuse(std::string sentence) {
    const std::lock_guard lock(mutex_);
    ++refused_;
    keep(std::move(sentence));
}

void LinkBoard::log(std::string sentence) {
    const std::lock_guard lock(mutex_);
    keep(std::move(sentence));
}

void LinkBoard::keep(std::string sentence) {
    constexpr size_t longest_log = 200;
    if (log_.size() >= longest_log) log_.pop_front();
    log_.push_back(std::move(sentence));
}

}  // namespace deixis
