// Model files are read in a short-lived child process: what crashes or holds the CAD libraries ends there.
#pragma once

#include <filesystem>

#include "tracking/geometry/result.h"
#include "tracking/geometry/surface_mesh.h"

namespace deixis {

/// [model]: what the reading of a model file may take.
struct ModelReaderParams {
    double time_limit_s = 60;
    int memory_limit_mb = 4096;  ///< address space; not held in builds with a sanitizer
    InvalidSettings validate() const;
};

struct ModelReader {
    std::filesystem::path program;  ///< the `deixis` binary, which knows the command `model-reader`
    ModelReaderParams params = {};
};

/// Loads a STEP, IGES, STL, OBJ or PLY file (by extension, any case) as triangles in metres, the same bits as
/// `read_model_file` gives. Refuses what does not open, holds no triangle or a NaN, or is not 1 cm to 20 m
/// long, and what crashed the child or took it too long or too much, naming file and reason. Waits for the
/// child; any number of threads may call it.
Result<SurfaceMesh> load_mesh(const std::filesystem::path& model, double metres_per_unit,
                              const ModelReader& reader);

}  // namespace deixis
