// The station's side of the Modbus TCP link to the PLC, on a thread of its own. States and defects in, part
// and echo out. The frame loop never waits for it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "appliance/plc/register_map.h"
#include "tracking/geometry/result.h"

namespace deixis {

struct PlcParams {
    std::string mode = "off";  ///< "off", "server" (the PLC asks the station) or "client" (the station asks)
    std::string address =
        "127.0.0.1";  ///< server: IPv4 address to listen on; client: IPv4 address of the PLC
    int port = 1502;  ///< 1 to 65535; 0 = any free one (server; tests)
    std::string allowed =
        "127.0.0.1";          ///< server: IPv4 addresses that may connect, "a.b.c.d" or "a.b.c.d/n", by comma
    int max_connections = 4;  ///< server: 1 to 32
    int request_timeout_ms = 1'000;  ///< server: a request begun must be complete by then, 50 to 60000
    int idle_timeout_ms = 60'000;    ///< server: a silent connection is closed after, 1000 to 3600000
    int unit = 255;                  ///< client: unit identifier of the PLC, 0 to 255 (server: any is served)
    int to_plc_address = 100;        ///< client: holding register of the PLC where the block "to PLC" begins
    int from_plc_address = 0;        ///< client: where the block "from PLC" begins
    int cycle_ms = 100;              ///< client: time between exchanges, 10 to 60000
    int answer_timeout_ms = 300;     ///< client: deadline of one request, 10 to 10000
    int reconnect_first_ms = 100;    ///< client: first wait before connecting again, 10 to 60000
    int reconnect_longest_ms = 5'000;  ///< client: the waits double up to this
    int heartbeat_timeout_ms = 2'000;  ///< PLC counts as silent when plc_heartbeat stands still so long
    int stale_ms = 1'000;              ///< no publish() for so long: the status word goes to 0
    int queue_length = 256;            ///< defects that may wait for the PLC's echo, 1 to 100000
    InvalidSettings validate() const;
};

enum class LinkPhase {
    off,        ///< no PLC is configured
    waiting,    ///< server: nobody is connected; client: not connected, trying
    connected,  ///< exchanging, but the PLC's heartbeat stands still
    alive,      ///< exchanging, heartbeat changes
};

/// "off", "waiting", "connected" or "alive".
const char* name_of(LinkPhase phase);

struct LinkState {
    LinkPhase phase = LinkPhase::off;
    std::string reason;  ///< one sentence unless off or alive
    int connections = 0;
    int defects_waiting = 0;  ///< not yet echoed
    uint64_t requests = 0;    ///< server: answered; client: exchanges done
    uint64_t refused = 0;     ///< server: requests and connections refused; client: requests failed
    uint64_t defects_echoed = 0;
};

/// Threads: all members from any thread; none waits for the network (the destructor: at most one request).
class PlcLink {
  public:
    /// Server: listens before it returns, and refuses a port that is taken. Client: never fails for a missing
    /// PLC, that is a state. Refuses bad params by name.
    static Result<std::unique_ptr<PlcLink>> start(const PlcParams& params);
    ~PlcLink();

    /// The newest state wins; each call is one heartbeat.
    void publish(const PlcOutputs& outputs);

    /// Queues a committed defect; it stands in the registers until the PLC echoes it, one after the other. A
    /// full queue refuses the new one with a sentence: it is not lost, the ledger lists it as undelivered.
    /// One that waits already is not queued twice.
    Result<void> deliver(const PlcDefect& defect);

    /// Defects that the PLC has echoed since the last call, in order: note them in the ledger.
    std::vector<DefectId> take_echoed();

    /// The newest complete word of the PLC; part_sequence 0 until it named a part.
    PlcInputs inputs() const;

    LinkState state() const;

    /// What was refused or went wrong since the last call, one sentence each, with the peer's address; at
    /// most 200 are kept, the oldest go first.
    std::vector<std::string> take_log();

    /// The port that the server listens on; 0 otherwise.
    int port() const;

    /// "libmodbus 3.1.6".
    static std::string library_version();

    PlcLink(const PlcLink&) = delete;
    PlcLink& operator=(const PlcLink&) = delete;

  private:
    class Runner;
    explicit PlcLink(std::unique_ptr<Runner> runner);
    std::unique_ptr<Runner> runner_;
};

}  // namespace deixis
