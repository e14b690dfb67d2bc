// The web page read into memory.
#include "hmi/server/static_files.h"

#include <fstream>
#include <iterator>
#include <system_error>

namespace deixis {
namespace {

constexpr uintmax_t max_total_bytes = 64U << 20U;

std::string content_type_of(const std::filesystem::path& file) {
    static const std::map<std::string, std::string> types = {{".html", "text/html; charset=utf-8"},
                                                             {".js", "text/javascript; charset=utf-8"},
                                                             {".css", "text/css; charset=utf-8"},
                                                             {".svg", "image/svg+xml"},
                                                             {".png", "image/png"},
                                                             {".woff2", "font/woff2"},
                                                             {".json", "application/json"},
                                                             {".txt", "text/plain; charset=utf-8"}};
    const auto found = types.find(file.extension().string());
    return found == types.end() ? "application/octet-stream" : found->second;
}

}  // namespace

Result<StaticFiles> StaticFiles::read(const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (!fs::is_regular_file(folder / "index.html", error))
        return fail("web_root '" + folder.string() +
                    "' holds no index.html; build the target deixis_web or name its folder.");
    StaticFiles files;
    uintmax_t total = 0;
    for (auto entry = fs::recursive_directory_iterator(folder, error);
         !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
        std::error_code vanished;
        if (entry->is_symlink(vanished) || !entry->is_regular_file(vanished)) continue;
        total += entry->file_size(error);
        if (error) break;
        if (total > max_total_bytes)
            return fail("web_root '" + folder.string() +
                        "' holds more than 64 MB; it must be the built page alone.");
        std::ifstream in(entry->path(), std::ios::binary);
        std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
        if (!in) return fail("The file '" + entry->path().string() + "' of web_root cannot be read.");
        std::string url_path(1, '/');
        url_path.append(entry->path().lexically_relative(folder).generic_string());
        std::string etag = entity_tag(bytes);
        files.files_[url_path] = {content_type_of(entry->path()), std::move(etag),
                                  std::make_shared<const std::string>(std::move(bytes))};
    }
    if (error) return fail("web_root '" + folder.string() + "' cannot be read: " + error.message() + ".");
    return files;
}

const StaticFile* StaticFiles::find(const std::string& url_path) const {
    const auto found = url_path == "/" ? files_.find("/index.html") : files_.find(url_path);
    return found == files_.end() ? nullptr : &found->second;
}

}  // namespace deixis
