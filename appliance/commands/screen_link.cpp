// What the screen is told, and when.
#include "appliance/commands/screen_link.h"

#include <nlohmann/json.hpp>

#include "appliance/records/utc_time.h"
#include "hmi/server/screen_messages.h"

namespace deixis {
namespace {

/// The server sends 15 messages a second at most; more would only cost the frame loop time.
constexpr std::chrono::milliseconds least_gap{50};

std::shared_ptr<const ScreenPart> screen_part(const KnownPart& known, const std::string& serial) {
    auto part = std::make_shared<ScreenPart>();
    part->type = known.file.type;
    part->serial = serial;
    for (const Zone& zone : known.file.zones) part->zones.push_back({zone.name, zone.box});
    part->mesh = known.mesh;
    return part;
}

nlohmann::ordered_json mark_json(const DefectRecord& record) {
    const auto vector = [](const Eigen::Vector3d& v) { return nlohmann::ordered_json{v.x(), v.y(), v.z()}; };
    return {{"id", record.id},
            {"position_part", vector(record.mark.spot.position)},
            {"normal_part", vector(record.mark.spot.normal)},
            {"zone", record.zone},
            {"arm", name_of(record.mark.arm)},
            {"time", utc_text(record.time_us)},
            {"confidence", record.mark.confidence},
            {"state", name_of(record.state)},
            {"touch", record.mark.touch}};
}

}  // namespace

Result<std::unique_ptr<ScreenLink>> ScreenLink::start(const ScreenServerParams& params, const WorkCell& cell,
                                                      const std::filesystem::path& database) {
    std::unique_ptr<ScreenLink> link(new ScreenLink());
    link->database_ = database;
    link->rig_ = std::make_shared<const SensorRig>(cell.rig);
    if (cell.part) {
        link->part_ = screen_part(*cell.part, cell.part->file.serial);
        link->load_marks();
    }
    auto server = ScreenServer::start(params, *link);
    if (!server) return tl::unexpected(server.error());
    link->server_ = std::move(*server);
    return link;
}

void ScreenLink::load_marks() {
    DefectFilter of_part;
    of_part.part_type = part_->type;
    of_part.part_serial = part_->serial;
    marks_.clear();
    unreadable_.reset();
    if (part_->serial.empty()) return;  // parts that nobody can tell apart share no marks
    // The station has checked every page when it opened the record.
    LedgerParams unchecked;
    unchecked.check_on_open = false;
    const auto ledger = DefectLedger::open_to_read(database_, unchecked);
    auto found = ledger ? ledger->list(of_part) : tl::unexpected(ledger.error());
    if (found)
        marks_ = std::move(*found);
    else
        unreadable_ = Failure{found.error().sentence};
}

void ScreenLink::show(const Station& station, bool fresh) {
    {
        const std::lock_guard lock(mutex_);
        if (part_ && (part_->serial != station.part().serial || part_->type != station.part().type)) {
            auto part = std::make_shared<ScreenPart>(*part_);
            part->type = station.part().type;
            part->serial = station.part().serial;
            part_ = part;
            load_marks();
        } else {
            marks_.insert(marks_.end(), station.acknowledged().begin(), station.acknowledged().end());
        }
    }
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < least_gap && station.acknowledged().empty()) return;
    last_ = now;
    std::vector<uint8_t> voxels;
    if (fresh) {
        station.worker_voxels(voxels_);
        voxels = encode_voxels(voxels_, station.voxel_size(), station.result().timestamp_us);
    }
    server_->publish(live_message(station.state(), fresh ? &station.result() : nullptr).dump(),
                     std::move(voxels));
}

std::shared_ptr<const ScreenPart> ScreenLink::part() {
    const std::lock_guard lock(mutex_);
    return part_;
}

std::shared_ptr<const SensorRig> ScreenLink::rig() {
    const std::lock_guard lock(mutex_);
    return rig_;
}

Result<std::string> ScreenLink::marks_json() {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    const std::lock_guard lock(mutex_);
    if (unreadable_) return tl::unexpected(*unreadable_);
    for (const DefectRecord& record : marks_) list.push_back(mark_json(record));
    return list.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace deixis
