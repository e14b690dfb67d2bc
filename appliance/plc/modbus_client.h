// The station as Modbus TCP client: writes its block into the PLC, reads the PLC's block, once a cycle.
#pragma once

#include "appliance/plc/link_board.h"
#include "appliance/plc/plc_link.h"

namespace deixis {

/// Exchanges until `stop_event` (a file descriptor) becomes readable. One request in flight, each with the
/// deadline answer_timeout_ms; after any failure the connection is thrown away, with what its send buffer
/// still holds, and made anew after a wait that doubles. Nothing is queued but the defects on the board: the
/// newest state is sent.
void run_modbus_client(const PlcParams& params, LinkBoard& board, int stop_event);

}  // namespace deixis
