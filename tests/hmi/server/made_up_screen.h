// A screen server over a made-up page and station, for tests.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "hmi/server/screen_server.h"

namespace deixis {

/// Answers what its members hold; set them before the first request.
class MadeUpFeed : public ScreenFeed {
  public:
    std::shared_ptr<const ScreenPart> part() override { return known_part; }
    std::shared_ptr<const SensorRig> rig() override { return known_rig; }
    Result<std::string> marks_json() override { return marks(); }

    std::shared_ptr<const ScreenPart> known_part;
    std::shared_ptr<const SensorRig> known_rig;
    std::function<Result<std::string>()> marks = [] { return Result<std::string>("[]"); };
};

/// A folder with index.html, app.js and fonts/a.woff2, and a secret beside it; removed at the end.
class MadeUpPage {
  public:
    MadeUpPage();
    ~MadeUpPage();
    MadeUpPage(const MadeUpPage&) = delete;
    MadeUpPage& operator=(const MadeUpPage&) = delete;

    std::filesystem::path root() const { return folder_ / "web"; }

  private:
    std::filesystem::path folder_;
};

/// Parameters for any free port, with this page.
ScreenServerParams test_params(const MadeUpPage& page);

/// A tetrahedron with a zone.
std::shared_ptr<const ScreenPart> made_up_part();

/// Starts or throws the sentence.
std::unique_ptr<ScreenServer> must_start(const ScreenServerParams& params, ScreenFeed& feed);

}  // namespace deixis
