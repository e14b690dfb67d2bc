// Modbus TCP requests.
#include <cstdlib>

#include "appliance/plc/modbus_request.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using Kind = deixis::RequestVerdict::Kind;
    for (size_t at = 0; at < size;) {
        const auto verdict = deixis::judge_request(data + at, size - at);
        if (verdict.kind == Kind::except || verdict.kind == Kind::close)
            deixis::expect_one_sentence(verdict.sentence);
        if (verdict.kind == Kind::incomplete || verdict.kind == Kind::close) return 0;
        if (verdict.length == 0 || verdict.length > size - at || verdict.length > deixis::longest_request)
            std::abort();
        at += verdict.length;
    }
    return 0;
}
