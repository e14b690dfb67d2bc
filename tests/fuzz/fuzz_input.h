// What every fuzz entry needs: the input as a file, and the law that a refusal is one sentence.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "tracking/geometry/result.h"

namespace deixis {

/// The one file of this process that inputs are written to, in the temporary folder; `ending` with its dot.
std::filesystem::path input_as_file(const uint8_t* data, size_t size, const char* ending);

inline std::string_view as_text(const uint8_t* data, size_t size) {
    return {reinterpret_cast<const char*>(data), size};
}

/// Ends the process (a finding) when `sentence` is empty or has more than one line.
void expect_one_sentence(const std::string& sentence);

template <class T>
void expect_value_or_sentence(const Result<T>& result) {
    if (!result) expect_one_sentence(result.error().sentence);
}

}  // namespace deixis

/// Every entry is this function, as libFuzzer wants it.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
