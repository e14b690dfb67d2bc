// The built web page, read into memory once at start: what is not in this list cannot be asked for.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "hmi/server/http_answer.h"
#include "tracking/geometry/result.h"

namespace deixis {

struct StaticFile {
    std::string content_type;
    std::string etag;
    SharedBytes bytes;
};

class StaticFiles {
  public:
    /// Reads every regular file below `folder` (no symbolic links followed out of it). Refuses a folder
    /// without index.html, one with more than 64 MB, and a file that cannot be read.
    static Result<StaticFiles> read(const std::filesystem::path& folder);

    /// By URL path, "/" being index.html; null when there is no such file.
    const StaticFile* find(const std::string& url_path) const;

  private:
    std::map<std::string, StaticFile> files_;
};

}  // namespace deixis
