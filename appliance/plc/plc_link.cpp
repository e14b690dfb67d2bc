// Chooses the mode, owns the thread.
#include "appliance/plc/plc_link.h"

#include <modbus/modbus.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <thread>

#include "appliance/plc/address_list.h"
#include "appliance/plc/link_board.h"
#include "appliance/plc/modbus_client.h"
#include "appliance/plc/modbus_server.h"

namespace deixis {

const char* name_of(LinkPhase phase) {
    switch (phase) {
        case LinkPhase::off:
            return "off";
        case LinkPhase::waiting:
            return "waiting";
        case LinkPhase::connected:
            return "connected";
        case LinkPhase::alive:
            return "alive";
    }
    return "off";
}

namespace {

void check_address(InvalidSettings& complaints, const PlcParams& params) {
    const auto address = ipv4_of(params.address);
    if (!address)
        complaints.push_back({"address", params.address, "an IPv4 address as 192.168.3.7"});
    else if (*address == 0)
        complaints.push_back({"address", params.address, "the address of one interface, by name"});
    if (params.mode != "server") return;
    if (auto allowed = AddressList::read(params.allowed); !allowed)
        complaints.push_back({"allowed", params.allowed, "IPv4 addresses or networks, by comma"});
}

void check_blocks(InvalidSettings& complaints, const PlcParams& params) {
    require_range(complaints, "to_plc_address", params.to_plc_address, 0, 65'536 - to_plc_registers);
    require_range(complaints, "from_plc_address", params.from_plc_address, 0, 65'536 - from_plc_registers);
    if (params.to_plc_address < params.from_plc_address + from_plc_registers &&
        params.from_plc_address < params.to_plc_address + to_plc_registers)
        complaints.push_back({"to_plc_address", std::to_string(params.to_plc_address),
                              "a block of " + std::to_string(to_plc_registers) +
                                  " registers that does not overlap the one from from_plc_address on"});
}

}  // namespace

InvalidSettings PlcParams::validate() const {
    InvalidSettings complaints;
    if (mode != "off" && mode != "server" && mode != "client")
        complaints.push_back({"mode", mode, "\"off\", \"server\" or \"client\""});
    check_address(complaints, *this);
    check_blocks(complaints, *this);
    require_range(complaints, "port", port, mode == "server" ? 0 : 1, 65'535);
    require_range(complaints, "max_connections", max_connections, 1, 32);
    require_range(complaints, "request_timeout_ms", request_timeout_ms, 50, 60'000);
    require_range(complaints, "idle_timeout_ms", idle_timeout_ms, 1'000, 3'600'000);
    require_range(complaints, "unit", unit, 0, 255);
    require_range(complaints, "cycle_ms", cycle_ms, 10, 60'000);
    require_range(complaints, "answer_timeout_ms", answer_timeout_ms, 10, 10'000);
    require_range(complaints, "reconnect_first_ms", reconnect_first_ms, 10, 60'000);
    require_range(complaints, "reconnect_longest_ms", reconnect_longest_ms, reconnect_first_ms, 600'000);
    require_range(complaints, "heartbeat_timeout_ms", heartbeat_timeout_ms, 100, 600'000);
    require_range(complaints, "stale_ms", stale_ms, 100, 60'000);
    require_range(complaints, "queue_length", queue_length, 1, 100'000);
    return complaints;
}

class PlcLink::Runner {
  public:
    Runner(const PlcParams& params, int stop_event)
        : params_(params), board_(params), stop_event_(stop_event) {}

    ~Runner() {
        const uint64_t one = 1;
        if (::write(stop_event_, &one, sizeof one) == sizeof one && thread_.joinable()) thread_.join();
        ::close(stop_event_);
    }
    Runner(const Runner&) = delete;
    Runner& operator=(const Runner&) = delete;

    Result<void> begin() {
        if (params_.mode == "server") {
            auto server = ModbusServer::listen(params_, board_);
            if (!server) return tl::unexpected(server.error());
            server_ = std::move(*server);
            thread_ = std::thread([this] { server_->serve(stop_event_); });
        } else if (params_.mode == "client") {
            thread_ = std::thread([this] { run_modbus_client(params_, board_, stop_event_); });
        }
        return {};
    }

    bool off() const { return params_.mode == "off"; }
    LinkBoard& board() { return board_; }
    int port() const { return server_ ? server_->port() : 0; }

  private:
    const PlcParams params_;
    LinkBoard board_;
    const int stop_event_;
    std::unique_ptr<ModbusServer> server_;
    std::thread thread_;
};

Result<std::unique_ptr<PlcLink>> PlcLink::start(const PlcParams& params) {
    if (const InvalidSettings complaints = params.validate(); !complaints.empty())
        return fail("the setting plc." + complaints[0].key + " is \"" + complaints[0].value +
                    "\"; expected " + complaints[0].range);
    const int stop_event = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (stop_event < 0) return fail("the PLC link cannot start: the process has no file descriptor left");
    auto runner = std::make_unique<Runner>(params, stop_event);
    if (auto begun = runner->begin(); !begun) return tl::unexpected(begun.error());
    return std::unique_ptr<PlcLink>(new PlcLink(std::move(runner)));
}

PlcLink::PlcLink(std::unique_ptr<Runner> runner) : runner_(std::move(runner)) {}
PlcLink::~PlcLink() = default;

void PlcLink::publish(const PlcOutputs& outputs) {
    runner_->board().publish(outputs);
}

Result<void> PlcLink::deliver(const PlcDefect& defect) {
    if (runner_->off()) return {};  // nobody to tell
    return runner_->board().deliver(defect);
}

std::vector<DefectId> PlcLink::take_echoed() {
    return runner_->board().take_echoed();
}
PlcInputs PlcLink::inputs() const {
    return runner_->board().inputs();
}
LinkState PlcLink::state() const {
    return runner_->off() ? LinkState{} : runner_->board().state();
}
std::vector<std::string> PlcLink::take_log() {
    return runner_->board().take_log();
}
std::string PlcLink::library_version() {
    return "libmodbus " + std::to_string(libmodbus_version_major) + "." +
           std::to_string(libmodbus_version_minor) + "." + std::to_string(libmodbus_version_micro);
}
int PlcLink::port() const {
    return runner_->port();
}

}  // namespace deixis
