// WebSocket frames of a client.
#include <cstdlib>

#include "hmi/server/web_socket_frames.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    std::string_view rest = deixis::as_text(data, size);
    deixis::is_web_socket_key(rest.substr(0, 24));
    while (!rest.empty()) {
        const auto frame = deixis::read_client_frame(rest);
        if (!frame) {
            deixis::expect_one_sentence(frame.error().sentence);
            return 0;
        }
        if (!*frame) return 0;
        if ((*frame)->bytes == 0 || (*frame)->bytes > rest.size()) std::abort();
        rest.remove_prefix((*frame)->bytes);
    }
    return 0;
}
