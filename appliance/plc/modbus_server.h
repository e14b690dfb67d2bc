// The station as Modbus TCP server: four functions, two blocks of registers, everything else refused in a
// sentence.
#pragma once

#include <memory>

#include "appliance/plc/link_board.h"
#include "appliance/plc/plc_link.h"

namespace deixis {

class ModbusServer {
  public:
    /// Listens on params.address and params.port; refuses an address or port that it cannot have.
    static Result<std::unique_ptr<ModbusServer>> listen(const PlcParams& params, LinkBoard& board);
    ~ModbusServer();

    int port() const;

    /// Serves until `stop_event` (a file descriptor) becomes readable. No client can hold it up: sockets do
    /// not block, a request that is not complete in time ends its connection.
    void serve(int stop_event);

    ModbusServer(const ModbusServer&) = delete;
    ModbusServer& operator=(const ModbusServer&) = delete;

  private:
    class Sockets;
    explicit ModbusServer(std::unique_ptr<Sockets> sockets);
    std::unique_ptr<Sockets> sockets_;
};

}  // namespace deixis
