// libmodbus without its own link recovery, which would block for as long as the PLC is away.
#include "appliance/plc/modbus_client.h"

#include <modbus/modbus.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <memory>

namespace deixis {
namespace {

struct ClientContextDeleter {
    void operator()(modbus_t* context) const {
        modbus_close(context);
        modbus_free(context);
    }
};
using Context = std::unique_ptr<modbus_t, ClientContextDeleter>;

/// True when it is time to end.
bool pause(int stop_event, int wait_ms) {
    pollfd event{stop_event, POLLIN, 0};
    return ::poll(&event, 1, wait_ms) > 0;
}

class Exchange {
  public:
    Exchange(const PlcParams& params, LinkBoard& board)
        : params_(params), board_(board), peer_(params.address + ":" + std::to_string(params.port)) {}

    /// Empty when the connection stands; else why not.
    std::string connect() {
        context_.reset(modbus_new_tcp(params_.address.c_str(), params_.port));
        modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
        modbus_set_slave(context_.get(), params_.unit);
        modbus_set_response_timeout(context_.get(), static_cast<uint32_t>(params_.answer_timeout_ms / 1000),
                                    static_cast<uint32_t>(params_.answer_timeout_ms % 1000) * 1000);
        modbus_set_byte_timeout(context_.get(), 0, 0);  // the deadline holds for the whole answer
        if (modbus_connect(context_.get()) != 0) return failure("cannot reach the PLC at " + peer_);
        // On close, drop what the peer has not taken: a PLC that comes back must not be flooded with old
        // states.
        const linger drop{1, 0};
        ::setsockopt(modbus_get_socket(context_.get()), SOL_SOCKET, SO_LINGER, &drop, sizeof drop);
        return {};
    }

    void disconnect() { context_.reset(); }

    /// Reads before it writes: what the PLC echoed last must be known when a defect is first shown to it.
    std::string once() {
        FromPlcWords said{};
        if (modbus_read_registers(context_.get(), params_.from_plc_address, from_plc_registers,
                                  said.data()) != from_plc_registers)
            return failure("the PLC at " + peer_ + " does not give its registers " +
                           range(params_.from_plc_address, from_plc_registers));
        board_.read_from_plc(said);
        const ToPlcWords words = board_.words_for_plc();
        if (modbus_write_registers(context_.get(), params_.to_plc_address, to_plc_registers, words.data()) !=
            to_plc_registers)
            return failure("the PLC at " + peer_ + " does not take its registers " +
                           range(params_.to_plc_address, to_plc_registers));
        board_.count_request();
        return {};
    }

  private:
    static std::string range(int first, int count) {
        return std::to_string(first) + " to " + std::to_string(first + count - 1);
    }

    std::string failure(const std::string& what) const {
        const int code = errno;
        if (code == ETIMEDOUT || code == EINPROGRESS)
            return what + ": no answer within " + std::to_string(params_.answer_timeout_ms) + " ms";
        if (code == EMBXILADD) return what + ": it has no such registers; compare with `deixis plc map`";
        return what + ": " + modbus_strerror(code);
    }

    const PlcParams& params_;
    LinkBoard& board_;
    const std::string peer_;
    Context context_;
};

}  // namespace

void run_modbus_client(const PlcParams& params, LinkBoard& board, int stop_event) {
    Exchange exchange(params, board);
    int wait_ms = params.reconnect_first_ms;
    std::string told;  // a sentence is logged once, not at every try
    board.set_connections(
        0, "not yet connected to the PLC at " + params.address + ":" + std::to_string(params.port));
    for (;;) {
        std::string trouble = exchange.connect();
        while (trouble.empty()) {
            trouble = exchange.once();
            if (!trouble.empty()) break;
            board.set_connections(1, "");
            wait_ms = params.reconnect_first_ms;
            told.clear();
            if (pause(stop_event, params.cycle_ms)) return;
        }
        exchange.disconnect();
        board.set_connections(0, trouble);
        if (trouble != told) board.refuse("PLC link: " + trouble);
        told = trouble;
        if (pause(stop_event, wait_ms)) return;
        wait_ms = std::min(2 * wait_ms, params.reconnect_longest_ms);
    }
}

}  // namespace deixis
