// The made-up page and station.
#include "tests/hmi/server/made_up_screen.h"

#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace deixis {

MadeUpPage::MadeUpPage() {
    std::string pattern = (std::filesystem::temp_directory_path() / "screen.XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no folder for the page");
    folder_ = pattern;
    std::filesystem::create_directories(root() / "fonts");
    std::ofstream(root() / "index.html") << "<!doctype html><title>page</title>";
    std::ofstream(root() / "app.js") << "export {};\n";
    std::ofstream(root() / "fonts" / "a.woff2") << "font";
    std::ofstream(folder_ / "secret.txt") << "secret";
    std::filesystem::create_symlink(folder_ / "secret.txt", root() / "link.txt");
}

MadeUpPage::~MadeUpPage() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

ScreenServerParams test_params(const MadeUpPage& page) {
    ScreenServerParams params;
    params.port = 0;
    params.web_root = page.root().string();
    return params;
}

std::shared_ptr<const ScreenPart> made_up_part() {
    auto part = std::make_shared<ScreenPart>();
    part->type = "bumper-front-a";
    part->serial = "0001";
    part->zones = {{"upper left", {{-1, -1, 0}, {0, 1, 1}}}};
    part->mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    part->mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    return part;
}

std::unique_ptr<ScreenServer> must_start(const ScreenServerParams& params, ScreenFeed& feed) {
    auto server = ScreenServer::start(params, feed);
    if (!server) throw std::runtime_error(server.error().sentence);
    return std::move(*server);
}

}  // namespace deixis
