// Inputs as files, and the law of one sentence.
#include "tests/fuzz/fuzz_input.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace deixis {

std::filesystem::path input_as_file(const uint8_t* data, size_t size, const char* ending) {
    const std::string name = "deixis-fuzz-" + std::to_string(getpid()) + ending;
    static const std::filesystem::path path = std::filesystem::temp_directory_path() / name;
    static const int registered = std::atexit([] {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
    });
    if (registered != 0) std::abort();
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    if (!out.flush()) std::abort();
    return path;
}

void expect_one_sentence(const std::string& sentence) {
    if (!sentence.empty() && sentence.find('\n') == std::string::npos) return;
    std::fprintf(stderr, "not one sentence: \"%s\"\n", sentence.c_str());
    std::abort();
}

}  // namespace deixis
