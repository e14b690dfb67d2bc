// What a PLY file promises in its header against what it holds, before a reader relies on it.
#pragma once

#include <string>
#include <string_view>

#include "tracking/geometry/result.h"

namespace deixis {

/// Walks the header and every element of the PLY file whose bytes are `bytes`. Refuses a header that is not
/// PLY 1.0, elements that are cut short or hold no number, and faces with a corner that is none of the
/// vertices, naming `file`. Assimp 5.2 hangs or reads beyond its memory on such files.
Result<void> check_ply(std::string_view bytes, const std::string& file);

}  // namespace deixis
