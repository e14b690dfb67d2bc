// HTTP request heads.
#include <cstdlib>

#include "hmi/server/http_request.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view arrived = deixis::as_text(data, size);
    const auto head = deixis::find_request_head(arrived);
    if (!head) {
        deixis::expect_one_sentence(head.error().sentence);
        return 0;
    }
    if (!*head) return 0;
    if (**head > size) std::abort();
    const auto request = deixis::parse_request_head(arrived.substr(0, **head));
    if (!request) {
        deixis::expect_one_sentence(request.error().sentence);
        return 0;
    }
    const bool rooted = request->path.starts_with("/") && request->path.find("/../") == std::string::npos;
    if (!rooted) std::abort();
    deixis::is_loopback_host(request->header("host"));
    return 0;
}
