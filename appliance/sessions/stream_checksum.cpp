// The checksum of a stream's file or folder: "xxh3-64:<16 hex digits>".
#include "appliance/sessions/stream_checksum.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <vector>

namespace deixis {
namespace {

namespace fs = std::filesystem;

constexpr size_t chunk_bytes = size_t{1} << 20;

struct FreeState {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

Result<void> add_file(XXH3_state_t* state, const fs::path& path, std::vector<char>& chunk) {
    std::ifstream in(path, std::ios::binary);
    if (!in) return fail(path.string() + ": cannot be opened");
    while (in) {
        in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
        XXH3_64bits_update(state, chunk.data(), static_cast<size_t>(in.gcount()));
    }
    if (in.bad() || !in.eof()) return fail(path.string() + ": cannot be read");
    return {};
}

}  // namespace

Result<std::string> stream_checksum(const fs::path& file_or_folder) {
    std::vector<fs::path> files;
    std::error_code error;
    if (fs::is_directory(file_or_folder, error)) {
        for (const auto& entry : fs::directory_iterator(file_or_folder, error))
            if (entry.path().extension() == ".png") files.push_back(entry.path());
        if (error) return fail(file_or_folder.string() + ": cannot be listed: " + error.message());
        std::sort(files.begin(), files.end());
        files.insert(files.begin(), file_or_folder / "timestamps.csv");
    } else {
        files.push_back(file_or_folder);
    }
    const std::unique_ptr<XXH3_state_t, FreeState> state(XXH3_createState());
    XXH3_64bits_reset(state.get());
    std::vector<char> chunk(chunk_bytes);
    for (const fs::path& file : files)
        if (auto added = add_file(state.get(), file, chunk); !added) return tl::unexpected(added.error());
    std::array<char, 17> digits = {};
    std::snprintf(digits.data(), digits.size(), "%016llx",
                  static_cast<unsigned long long>(XXH3_64bits_digest(state.get())));
    return std::string("xxh3-64:") + digits.data();
}

}  // namespace deixis
