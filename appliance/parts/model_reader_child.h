// The child behind `load_mesh`: what it is asked, and what it answers.
#pragma once

#include <cstdint>
#include <filesystem>

#include "appliance/parts/model_reader.h"

namespace deixis {

/// The order that `load_mesh` gives to its child, as the options of `deixis model-reader`.
struct ModelRequest {
    std::filesystem::path model;
    double metres_per_unit = 0.001;
    ModelReaderParams limits;
    int reply_file = -1;  ///< open file that takes the reply
};

/// What stands before the bytes of a reply: `vertices` times three floats and `triangles` times three
/// indices, or, with `sentence` > 0, that many characters of a refusal. Both ends are the same program.
struct ModelReplyHead {
    static constexpr uint64_t right_mark = 0x31'68'73'65'6d'69'78'64;
    uint64_t mark = right_mark;
    uint64_t sentence = 0, vertices = 0, triangles = 0;
};

/// The child's whole life: limits itself, reads the file, writes the reply, ends the process.
[[noreturn]] void run_model_reader(const ModelRequest& request);

}  // namespace deixis
