// Modbus Application Protocol 1.1b3, sections 4 and 6, and the TCP header of the Messaging Guide,
// section 3.1.3.
#include "appliance/plc/modbus_request.h"

#include "appliance/plc/register_map.h"

namespace deixis {
namespace {

constexpr size_t header_length = 7;
constexpr int illegal_function = 1, illegal_address = 2, illegal_value = 3;

struct Pdu {
    const uint8_t* data;
    size_t size;
    int byte(size_t i) const { return data[i]; }
    int word(size_t i) const { return data[i] << 8 | data[i + 1]; }
};

RequestVerdict refuse(int exception, std::string sentence) {
    RequestVerdict verdict;
    verdict.kind = RequestVerdict::Kind::except;
    verdict.exception = exception;
    verdict.sentence = std::move(sentence);
    return verdict;
}

RequestVerdict serve(bool writes) {
    RequestVerdict verdict;
    verdict.kind = RequestVerdict::Kind::serve;
    verdict.writes = writes;
    return verdict;
}

RequestVerdict wrong_length(int function, size_t is, const std::string& expected) {
    return refuse(illegal_value, "function " + std::to_string(function) + " came with " + std::to_string(is) +
                                     " bytes; expected " + expected);
}

/// Judges `count` registers from `first` against a block of `registers`.
RequestVerdict judge_range(int first, int count, int most, int registers, const char* block, bool writes) {
    const std::string asked = std::to_string(count) + " registers from " + std::to_string(first);
    if (count < 1 || count > most)
        return refuse(illegal_value,
                      "asked for " + asked + "; expected 1 to " + std::to_string(most) + " at a time");
    if (first + count > registers)
        return refuse(illegal_address, "asked for " + asked + "; the block \"" + block + "\" has 0 to " +
                                           std::to_string(registers - 1));
    return serve(writes);
}

RequestVerdict judge_read(const Pdu& pdu) {
    if (pdu.size != 5) return wrong_length(pdu.byte(0), pdu.size, "5");
    if (pdu.byte(0) == 4)
        return judge_range(pdu.word(1), pdu.word(3), 125, to_plc_registers, "to PLC", false);
    return judge_range(pdu.word(1), pdu.word(3), 125, from_plc_registers, "from PLC", false);
}

RequestVerdict judge_write_one(const Pdu& pdu) {
    if (pdu.size != 5) return wrong_length(6, pdu.size, "5");
    return judge_range(pdu.word(1), 1, 1, from_plc_registers, "from PLC", true);
}

RequestVerdict judge_write_many(const Pdu& pdu) {
    if (pdu.size < 6) return wrong_length(16, pdu.size, "at least 8");
    const int count = pdu.word(3);
    RequestVerdict range = judge_range(pdu.word(1), count, 123, from_plc_registers, "from PLC", true);
    if (range.exception == illegal_value) return range;
    if (pdu.byte(5) != 2 * count)
        return refuse(illegal_value, "function 16 announced " + std::to_string(pdu.byte(5)) + " bytes for " +
                                         std::to_string(count) + " registers; expected " +
                                         std::to_string(2 * count));
    if (pdu.size != 6 + 2 * static_cast<size_t>(count))
        return wrong_length(16, pdu.size, std::to_string(6 + 2 * count));
    return range;
}

RequestVerdict judge_pdu(const Pdu& pdu) {
    switch (pdu.byte(0)) {
        case 3:
        case 4:
            return judge_read(pdu);
        case 6:
            return judge_write_one(pdu);
        case 16:
            return judge_write_many(pdu);
        default:
            return refuse(illegal_function, "function " + std::to_string(pdu.byte(0)) +
                                                " is not served; expected 3, 4, 6 or 16");
    }
}

RequestVerdict close_with(std::string sentence) {
    RequestVerdict verdict;
    verdict.kind = RequestVerdict::Kind::close;
    verdict.sentence = std::move(sentence);
    return verdict;
}

}  // namespace

RequestVerdict judge_request(const uint8_t* bytes, size_t size) {
    const Pdu head{bytes, size};
    if (size >= 4 && head.word(2) != 0)
        return close_with("protocol identifier " + std::to_string(head.word(2)) +
                          " is not Modbus TCP; expected 0");
    if (size < 6) return {};
    const size_t length = head.word(4);
    if (length < 2 || length > longest_request - 6)
        return close_with("announced a length of " + std::to_string(length) + " bytes; expected 2 to " +
                          std::to_string(longest_request - 6));
    if (size < 6 + length) return {};
    const Pdu pdu{bytes + header_length, length - 1};
    if (pdu.byte(0) == 0 || pdu.byte(0) >= 0x80)
        return close_with(std::to_string(pdu.byte(0)) + " is not a Modbus function; expected 1 to 127");
    RequestVerdict verdict = judge_pdu(pdu);
    verdict.length = 6 + length;
    return verdict;
}

}  // namespace deixis
