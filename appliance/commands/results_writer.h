// results.jsonl as it grows: one line a frameset, under its own name only when whole.
#pragma once

#include <filesystem>
#include <fstream>

#include "appliance/station/frame_result.h"
#include "tracking/geometry/result.h"

namespace deixis {

/// Writes to `<path>.partial` until `finish`, so that nobody takes a torn file for a short session.
class ResultsWriter {
  public:
    /// Refuses a path that cannot be written.
    static Result<ResultsWriter> create(const std::filesystem::path& path);

    void add(const FrameResult& result);

    /// Gives the file its name; refuses when not everything is on disk.
    Result<void> finish();

  private:
    ResultsWriter(std::filesystem::path path, std::filesystem::path partial, std::ofstream lines);
    std::filesystem::path path_, partial_;
    std::ofstream lines_;
};

}  // namespace deixis
