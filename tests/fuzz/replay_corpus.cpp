// Stands in for libFuzzer in the normal build: every file of the folders given goes through the entry, whole,
// cut short and with single bytes turned. Ends with an error when there is no file.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/fuzz/fuzz_input.h"

namespace {

void feed(const std::vector<uint8_t>& bytes) {
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

void feed_variants(const std::vector<uint8_t>& bytes) {
    feed(bytes);
    constexpr size_t steps = 16;
    for (size_t step = 0; step < steps; ++step) {
        feed({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() * step / steps)});
        if (bytes.empty()) continue;
        std::vector<uint8_t> turned = bytes;
        turned[bytes.size() * step / steps] ^= static_cast<uint8_t>(1U << (step % 8));
        feed(turned);
    }
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<std::filesystem::path> files;
    for (int i = 1; i < argc; ++i) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(argv[i])) {
            if (entry.is_regular_file()) files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    for (const std::filesystem::path& file : files) {
        std::ifstream in(file, std::ios::binary);
        feed_variants({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
    }
    std::printf("%zu inputs, each whole, cut and turned\n", files.size());
    return files.empty() ? 1 : 0;
}
