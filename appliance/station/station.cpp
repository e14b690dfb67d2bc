// One turn of the station: frameset, perception, record, PLC.
#include "appliance/station/station.h"

#include <algorithm>

#include "appliance/records/utc_time.h"
#include "appliance/sensors/host_clock.h"

namespace deixis {
namespace {

double ms_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

FrameSourceParams source_params(const StationSetup& setup) {
    FrameSourceParams params;
    params.lock_step = setup.lock_step;
    params.real_time = setup.real_time;
    params.stall_limit = std::chrono::milliseconds(setup.settings.sensors.stall_limit_ms);
    params.pair_patience = std::chrono::milliseconds(setup.settings.sensors.pair_patience_ms);
    params.restart_delay = std::chrono::milliseconds(setup.settings.sensors.restart_delay_ms);
    params.program = setup.program;
    params.driver_folder = setup.driver_folder;
    params.clock_us = setup.cell.clock_us;
    return params;
}

CommittedMark committed(const DefectRecord& record) {
    return {record.id, record.mark, record.zone};
}

}  // namespace

struct Station::Impl {
    StationSetup setup;
    Perception perception;
    DefectLedger ledger;
    std::unique_ptr<MarkRecorder> recorder;
    std::unique_ptr<PlcLink> plc;
    std::unique_ptr<FrameSource> source;
    Frameset frameset;
    FrameResult result;
    std::vector<DefectRecord> acknowledged;
    std::string trouble;
    std::string plc_said;  ///< newest sentence of the link's log: who was refused, and why
    int64_t framesets = 0;
    int64_t marks_total = 0;
    int64_t marks_on_part = 0;
    int64_t marks_lost = 0;
    PartInCell part;
    bool finished = false;
    DefectId echoed_up_to = 0;  ///< by the PLC in this run: it takes them in order
    bool record_readable = true;
    bool left_undelivered = false;  ///< the PLC's queue was full: the record knows more than it

    Impl(StationSetup s, DefectLedger l)
        : setup(std::move(s)), perception(setup.cell, setup.settings.perception), ledger(std::move(l)) {
        if (setup.cell.part) part = {setup.cell.part->file.type, setup.cell.part->file.serial, 0};
        marks_on_part = marks_in_record();
    }

    void look();
    void record(const Mark& mark);
    void collect();
    void acknowledge(const DefectRecord& record);
    void tell_plc(bool fresh);
    void hear_plc();
    double ms_since_arrival() const;
    void deliver_undelivered();
    void take_part(const PlcInputs& inputs);
    int64_t marks_in_record();
    std::vector<DefectRecord> read_record(const DefectFilter& filter);
    PlcDefect to_plc(const DefectRecord& record) const;
    DefectRecord record_of(const Mark& mark) const;
};

Station::Station(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Station::~Station() = default;

Result<std::unique_ptr<Station>> Station::start(StationSetup setup) {
    auto ledger = DefectLedger::open(setup.database, setup.settings.ledger);
    if (!ledger) return fail(ledger.error().sentence);
    auto impl = std::make_unique<Impl>(std::move(setup), std::move(*ledger));
    auto recorder = MarkRecorder::start(impl->ledger, impl->setup.settings.recorder);
    if (!recorder) return tl::unexpected(recorder.error());
    impl->recorder = std::move(*recorder);
    if (impl->setup.plc && impl->setup.settings.plc.mode != "off") {
        auto plc = PlcLink::start(impl->setup.settings.plc);
        if (!plc) return tl::unexpected(plc.error());
        impl->plc = std::move(*plc);
        impl->deliver_undelivered();
    }
    auto source = open_sensors(impl->setup.cell.sensors, source_params(impl->setup));
    if (!source) return tl::unexpected(source.error());
    impl->source = std::move(*source);
    return std::unique_ptr<Station>(new Station(std::move(impl)));
}

Station::Turn Station::turn(std::chrono::milliseconds patience) {
    Impl& s = *impl_;
    s.acknowledged.clear();
    s.hear_plc();
    const FrameSource::Outcome outcome = s.source->next(s.frameset, patience);
    if (outcome == FrameSource::Outcome::frameset) {
        s.look();
        return Turn::frame;
    }
    s.finished = outcome == FrameSource::Outcome::end;
    s.result = {};
    s.collect();
    s.tell_plc(false);
    return s.finished ? Turn::finished : Turn::waiting;
}

void Station::Impl::look() {
    const auto start = std::chrono::steady_clock::now();
    ++framesets;
    Perception::Observation observation = perception.update(frameset);
    result = std::move(observation.result);
    const auto before_record = std::chrono::steady_clock::now();
    if (observation.mark) record(*observation.mark);
    collect();
    tell_plc(true);
    result.stage_ms.record = ms_since(before_record);
    result.stage_ms.total = setup.lock_step ? ms_since(start) : ms_since_arrival();
}

/// Live, a frame waits in the ring and for its partner before it is looked at: that counts.
double Station::Impl::ms_since_arrival() const {
    int64_t arrived_us = 0;
    for (const DepthFrame& frame : frameset.frames)
        if (frame.present) arrived_us = std::max(arrived_us, frame.host_us);
    return static_cast<double>(host_now_us() - arrived_us) / 1000.0;
}

DefectRecord Station::Impl::record_of(const Mark& mark) const {
    DefectRecord record;
    record.part_type = part.type;
    record.part_serial = part.serial;
    record.mark = mark;
    if (setup.cell.part) record.zone = zone_of(setup.cell.part->file.zones, mark.spot.position);
    record.time_us =
        setup.lock_step ? setup.cell.epoch_us + (mark.timestamp_us - setup.cell.start_us) : utc_now_us();
    record.source = setup.cell.source;
    return record;
}

void Station::Impl::record(const Mark& mark) {
    DefectRecord defect = record_of(mark);
    if (setup.lock_step) {
        const auto id = recorder->commit_now(defect);
        if (!id) {
            trouble = "a mark could not be recorded: " + id.error().sentence;
            ++marks_lost;
            return;
        }
        defect.id = *id;
        acknowledge(defect);
    } else if (const auto posted = recorder->post(defect); !posted) {
        ++marks_lost;
        trouble = "a mark could not be recorded: " + posted.error().sentence;
    }
}

void Station::Impl::collect() {
    for (const DefectRecord& record : recorder->take_committed()) acknowledge(record);
    for (const RefusedMark& refused : recorder->take_refused())
        trouble = "a mark could not be recorded: " + refused.sentence;
}

void Station::Impl::acknowledge(const DefectRecord& record) {
    result.marks.push_back(committed(record));
    acknowledged.push_back(record);
    ++marks_total;
    if (record.part_serial == part.serial && record.part_type == part.type) ++marks_on_part;
    // While older ones wait for room the new one waits behind them, in the record: the PLC takes them in
    // order.
    if (!plc || left_undelivered) return;
    if (const auto queued = plc->deliver(to_plc(record)); !queued) {
        trouble = queued.error().sentence;
        left_undelivered = true;
    }
}

/// What the record holds and the PLC never echoed, of an earlier run or of a time when it was silent for so
/// long that the queue was full: each defect is delivered at least once.
void Station::Impl::deliver_undelivered() {
    left_undelivered = false;
    DefectFilter open_deliveries;
    open_deliveries.undelivered = true;
    const auto waiting = read_record(open_deliveries);
    for (const DefectRecord& record : waiting) {
        if (record.id <= echoed_up_to) continue;  // its echo is on the way into the record
        if (plc->deliver(to_plc(record))) continue;
        left_undelivered = true;
        return;
    }
}

PlcDefect Station::Impl::to_plc(const DefectRecord& record) const {
    PlcDefect defect;
    defect.id = record.id;
    defect.position = record.mark.spot.position;
    defect.arm = record.mark.arm;
    defect.confidence = record.mark.confidence;
    defect.part_serial = record.part_serial;
    if (setup.cell.part) {
        const auto& zones = setup.cell.part->file.zones;
        const auto zone =
            std::find_if(zones.begin(), zones.end(), [&](const Zone& z) { return z.name == record.zone; });
        if (zone != zones.end()) defect.zone_number = static_cast<int>(zone - zones.begin()) + 1;
    }
    return defect;
}

void Station::Impl::tell_plc(bool fresh) {
    if (!plc) return;
    const auto health = source->health();
    PlcOutputs outputs;
    outputs.sensors_ok = fresh && std::all_of(health.begin(), health.end(), [](const SensorHealth& h) {
                             return h.state == SensorState::running;
                         });
    outputs.part_locked = fresh && result.part.state == PartState::tracking;
    outputs.part_at_rest = outputs.part_locked && result.part.at_rest;
    const RecorderPhase phase = recorder->state().phase;
    outputs.database_ok =
        record_readable && (phase == RecorderPhase::ready || phase == RecorderPhase::writing);
    outputs.ready = outputs.sensors_ok && outputs.part_at_rest && outputs.database_ok;
    outputs.mark_toggle = marks_total % 2 != 0;
    outputs.pointing = fresh && result.pointing && result.pointing->hit;
    outputs.defect_count = marks_on_part;
    outputs.part_sequence_taken = part.sequence;
    plc->publish(outputs);
}

void Station::Impl::hear_plc() {
    if (!plc) return;
    for (const DefectId id : plc->take_echoed()) {
        recorder->note_delivered(id, utc_now_us());
        echoed_up_to = std::max(echoed_up_to, id);
    }
    for (std::string& sentence : plc->take_log()) plc_said = std::move(sentence);
    if (left_undelivered && plc->state().defects_waiting == 0) deliver_undelivered();
    if (const PlcInputs inputs = plc->inputs(); inputs.part_sequence != part.sequence) take_part(inputs);
}

/// Sequence 0: the part has left; what comes next is not booked to it.
void Station::Impl::take_part(const PlcInputs& inputs) {
    const std::string known = setup.cell.part ? setup.cell.part->file.type : "";
    part = {inputs.part_type.empty() ? known : inputs.part_type, inputs.part_serial, inputs.part_sequence};
    marks_on_part = marks_in_record();
    if (part.type != known)
        trouble = "the PLC says that a part of type \"" + part.type +
                  "\" is in the cell, the station knows \"" + known + "\"";
}

/// A part may come back, and a station may be started again.
int64_t Station::Impl::marks_in_record() {
    if (part.serial.empty()) return 0;
    DefectFilter of_part;
    of_part.part_type = part.type;
    of_part.part_serial = part.serial;
    const auto found = read_record(of_part);
    return std::count_if(found.begin(), found.end(),
                         [](const DefectRecord& r) { return r.state != DefectState::withdrawn; });
}

/// Without the check of every page that opening the record at the start has done. What cannot be read is
/// said, to the PLC too.
std::vector<DefectRecord> Station::Impl::read_record(const DefectFilter& filter) {
    LedgerParams unchecked = setup.settings.ledger;
    unchecked.check_on_open = false;
    auto reader = DefectLedger::open_to_read(setup.database, unchecked);
    auto found = reader ? reader->list(filter) : tl::unexpected(reader.error());
    record_readable = found.has_value();
    if (found) return std::move(*found);
    trouble = found.error().sentence;
    return {};
}

const FrameResult& Station::result() const {
    return impl_->result;
}
const std::vector<DefectRecord>& Station::acknowledged() const {
    return impl_->acknowledged;
}
const PartInCell& Station::part() const {
    return impl_->part;
}
float Station::voxel_size() const {
    return impl_->perception.voxel_size();
}

void Station::worker_voxels(std::vector<Eigen::Vector3f>& centres) const {
    impl_->perception.worker_voxels(centres);
}

StationState Station::state() const {
    const Impl& s = *impl_;
    StationState state;
    state.source = s.setup.cell.source;
    state.sensors = s.source->health();
    state.record = s.recorder->state();
    if (s.plc) state.plc = s.plc->state();
    state.framesets = s.framesets;
    state.expected = s.setup.cell.frames;
    state.finished = s.finished;
    state.marks_total = s.marks_total;
    state.plc_said = s.plc_said;
    state.marks_lost = s.marks_lost;
    state.last_trouble = s.trouble;
    return state;
}

std::vector<std::string> Station::stop() {
    std::vector<std::string> lost;
    for (const DefectRecord& record : impl_->recorder->stop())
        lost.push_back("the mark of session time " + std::to_string(record.mark.timestamp_us) +
                       " us was not acknowledged and is not in the record");
    return lost;
}

}  // namespace deixis
