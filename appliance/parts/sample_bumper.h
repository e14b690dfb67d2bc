// Bumpers of our own making for demo and tests: a thin shell with draw radii, recesses and sensor holes, as
// STEP.
#pragma once

#include <filesystem>

#include "tracking/geometry/result.h"

namespace deixis {

enum class SampleBumper {
    a,  ///< front bumper: 1.77 m wide, fog-lamp recesses of two kinds, plate recess, four sensor holes
    b   ///< rear bumper: 1.59 m wide, flatter, stepped profile, diffuser cut-out, plate left of the middle
};

/// Writes the bumper as a STEP file in millimetres (about 1.4 MB; the folder must exist). CAD frame: x along
/// the width, z up, the outer skin faces -y, origin in the middle at the lower edge. Same geometry on every
/// run (only the date in the STEP header differs). Refuses what cannot be modelled or written, naming the
/// file.
Result<void> write_sample_bumper(SampleBumper variant, const std::filesystem::path& step_file);

}  // namespace deixis
