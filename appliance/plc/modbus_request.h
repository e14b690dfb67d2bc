// One Modbus TCP request as bytes: is it complete, may it be served, and if not, why. Pure, no sockets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace deixis {

/// What to do with the bytes at the front of a connection.
struct RequestVerdict {
    enum class Kind { incomplete, serve, except, close } kind = Kind::incomplete;
    size_t length = 0;     ///< bytes of the whole request, when `serve` or `except`
    int exception = 0;     ///< Modbus exception code, when `except`
    bool writes = false;   ///< when `serve`: it changes the block from the PLC
    std::string sentence;  ///< why it is refused, when `except` or `close`
};

/// Judges the request that begins at `bytes`. Served: functions 3, 6 and 16 on the from_plc block's holding
/// registers, function 4 on the to_plc block's input registers, all lengths consistent; any unit identifier.
/// Exceptions: 1 another function, 2 registers beyond the block, 3 a count or length that does not fit.
/// Closed: a header that is not Modbus TCP, since what follows cannot be told apart.
RequestVerdict judge_request(const uint8_t* bytes, size_t size);

/// Longest request: 7 bytes header and 253 of function and data.
inline constexpr size_t longest_request = 260;

}  // namespace deixis
