// The source tree's files through `git ls-files`.
#include "tests/source_files.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>

namespace deixis {

std::filesystem::path source_root() {
    const char* root = std::getenv("DEIXIS_SOURCE");
    return root == nullptr ? std::filesystem::current_path() : std::filesystem::path(root);
}

std::vector<std::string> source_files() {
    const std::string command = "git -C '" + source_root().string() + "' ls-files -co --exclude-standard";
    const auto close = [](std::FILE* pipe) { pclose(pipe); };
    const std::unique_ptr<std::FILE, decltype(close)> pipe(popen(command.c_str(), "r"), close);
    std::string all;
    std::array<char, 4096> piece{};
    while (pipe && std::fgets(piece.data(), int(piece.size()), pipe.get()) != nullptr) all += piece.data();
    std::vector<std::string> files;
    for (size_t begin = 0; begin < all.size();) {
        const size_t end = std::min(all.find('\n', begin), all.size());
        const std::string file = all.substr(begin, end - begin);
        if (std::filesystem::is_regular_file(source_root() / file)) files.push_back(file);
        begin = end + 1;
    }
    std::sort(files.begin(), files.end());
    return files;
}

bool ends_in(const std::string& path, const std::vector<std::string>& endings) {
    return std::any_of(endings.begin(), endings.end(),
                       [&](const std::string& ending) { return path.ends_with(ending); });
}

std::vector<std::string> lines_of(const std::string& path) {
    std::ifstream in(source_root() / path);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

}  // namespace deixis
