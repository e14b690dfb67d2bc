// Modbus TCP requests as bytes, right and wrong ones.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

namespace deixis {

using Bytes = std::vector<uint8_t>;

/// Header (transaction 0x1234, unit 1) and `pdu`; `length` and `protocol` lie when given.
inline Bytes request(const Bytes& pdu, int length = -1, int protocol = 0) {
    const int announced = length >= 0 ? length : static_cast<int>(pdu.size()) + 1;
    Bytes bytes;
    for (const int byte : {0x12, 0x34, protocol >> 8, protocol & 255, announced >> 8, announced & 255, 1})
        bytes.push_back(static_cast<uint8_t>(byte));
    for (const uint8_t byte : pdu) bytes.push_back(byte);
    return bytes;
}

inline Bytes pdu(int function, std::initializer_list<int> words) {
    Bytes bytes{static_cast<uint8_t>(function)};
    for (const int word : words) {
        bytes.push_back(static_cast<uint8_t>(word >> 8));
        bytes.push_back(static_cast<uint8_t>(word));
    }
    return bytes;
}

/// Function 16 with `values` from `first`; `count` and `size` lie when given.
inline Bytes write_pdu(int first, const std::vector<uint16_t>& values, int count = -1, int size = -1) {
    Bytes bytes = pdu(16, {first, count >= 0 ? count : static_cast<int>(values.size())});
    bytes.push_back(static_cast<uint8_t>(size >= 0 ? size : static_cast<int>(2 * values.size())));
    for (const uint16_t value : values) {
        bytes.push_back(static_cast<uint8_t>(value >> 8));
        bytes.push_back(static_cast<uint8_t>(value));
    }
    return bytes;
}

struct BadRequest {
    Bytes bytes;
    int exception;  ///< 0: the connection is closed
    std::string sentence;
};

/// One of every kind that the station must refuse, with the essential part of its sentence.
inline std::vector<BadRequest> bad_requests() {
    const std::string not_served = " is not served; expected 3, 4, 6 or 16";
    return {
        {request(pdu(1, {0, 1})), 1, "function 1" + not_served},
        {request(pdu(2, {0, 1})), 1, "function 2" + not_served},
        {request(pdu(5, {0, 0xFF00})), 1, "function 5" + not_served},
        {request(pdu(7, {})), 1, "function 7" + not_served},
        {request(pdu(8, {0, 0})), 1, "function 8" + not_served},
        {request(pdu(15, {0, 1})), 1, "function 15" + not_served},
        {request(pdu(17, {})), 1, "function 17" + not_served},
        {request(pdu(22, {0, 0, 0})), 1, "function 22" + not_served},
        {request(pdu(23, {0, 1, 0, 1})), 1, "function 23" + not_served},
        {request(pdu(43, {0x0E01})), 1, "function 43" + not_served},
        {request(pdu(127, {})), 1, "function 127" + not_served},
        {request(pdu(3, {0, 0})), 3, "asked for 0 registers from 0; expected 1 to 125 at a time"},
        {request(pdu(3, {0, 126})), 3, "asked for 126 registers from 0; expected 1 to 125 at a time"},
        {request(pdu(4, {0, 65535})), 3, "asked for 65535 registers from 0; expected 1 to 125 at a time"},
        {request(pdu(3, {0, 37})), 2, "asked for 37 registers from 0; the block \"from PLC\" has 0 to 35"},
        {request(pdu(3, {36, 1})), 2, "asked for 1 registers from 36; the block \"from PLC\" has 0 to 35"},
        {request(pdu(4, {33, 2})), 2, "asked for 2 registers from 33; the block \"to PLC\" has 0 to 33"},
        {request(pdu(4, {65535, 125})), 2,
         "asked for 125 registers from 65535; the block \"to PLC\" has 0 to 33"},
        {request(pdu(6, {36, 1})), 2, "asked for 1 registers from 36; the block \"from PLC\" has 0 to 35"},
        {request(write_pdu(35, {1, 2})), 2,
         "asked for 2 registers from 35; the block \"from PLC\" has 0 to 35"},
        {request(write_pdu(0, {}, 0)), 3, "asked for 0 registers from 0; expected 1 to 123 at a time"},
        {request(write_pdu(0, {1, 2}, 124)), 3,
         "asked for 124 registers from 0; expected 1 to 123 at a time"},
        {request(write_pdu(0, {1, 2}, 2, 2)), 3, "announced 2 bytes for 2 registers; expected 4"},
        {request(write_pdu(0, {1, 2}, 2, 255)), 3, "announced 255 bytes for 2 registers; expected 4"},
        {request(write_pdu(0, {1, 2}, 3, 6)), 3, "function 16 came with 10 bytes; expected 12"},
        {request(write_pdu(0, {1, 2, 3}, 2, 4)), 3, "function 16 came with 12 bytes; expected 10"},
        {request(pdu(16, {0, 1})), 3, "function 16 came with 5 bytes; expected at least 8"},
        {request(pdu(3, {0})), 3, "function 3 came with 3 bytes; expected 5"},
        {request(pdu(3, {})), 3, "function 3 came with 1 bytes; expected 5"},
        {request(pdu(4, {0, 1, 0})), 3, "function 4 came with 7 bytes; expected 5"},
        {request(pdu(6, {0})), 3, "function 6 came with 3 bytes; expected 5"},
        {request(pdu(0, {0, 1})), 0, "0 is not a Modbus function; expected 1 to 127"},
        {request(pdu(0x83, {0, 1})), 0, "131 is not a Modbus function; expected 1 to 127"},
        {request(pdu(3, {0, 1}), -1, 1), 0, "protocol identifier 1 is not Modbus TCP; expected 0"},
        {request(pdu(3, {0, 1}), 0), 0, "announced a length of 0 bytes; expected 2 to 254"},
        {request(pdu(3, {0, 1}), 1), 0, "announced a length of 1 bytes; expected 2 to 254"},
        {request(pdu(3, {0, 1}), 255), 0, "announced a length of 255 bytes; expected 2 to 254"},
        {request(pdu(3, {0, 1}), 65535), 0, "announced a length of 65535 bytes; expected 2 to 254"},
        {Bytes{'G', 'E', 'T', ' ', '/', ' ', 'H', 'T', 'T', 'P', '\r', '\n'}, 0,
         "protocol identifier 21536 is not Modbus TCP; expected 0"},
        {Bytes(300, 0xFF), 0, "protocol identifier 65535 is not Modbus TCP; expected 0"},
        {Bytes(12, 0), 0, "announced a length of 0 bytes; expected 2 to 254"},
        {Bytes{0x16, 0x03, 0x01, 0x02, 0x00, 0x01}, 0,
         "protocol identifier 258 is not Modbus TCP; expected 0"},
    };
}

}  // namespace deixis
