// The frames folder that another program wrote: imported, then read back through our reader and stock
// OpenNI2.
#include <gtest/gtest.h>

#include <cstdlib>

#include "appliance/sessions/import_frames.h"
#include "appliance/sessions/session.h"
#include "tests/appliance/sessions/imported_frames.h"
#include "tests/appliance/sessions/scratch_folder.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;
using namespace testing;  // NOLINT: our own helpers

fs::path data_folder() {
    if (const char* data = std::getenv("DEIXIS_DATA")) return data;
    const char* source = std::getenv("DEIXIS_SOURCE");
    return fs::path(source == nullptr ? "." : source) / "../shared/data";
}

TEST(ImportSample, EveryFrameComesBackBitForBit) {
    const fs::path frames = data_folder() / "sample_frames";
    if (!fs::exists(frames)) GTEST_SKIP() << "no " << frames;
    const ScratchFolder scratch;
    const auto report = import_frames(frames, scratch / "out", {"sample", "2026-11-22T10:00:00Z", {}});
    ASSERT_TRUE(report) << report.error().sentence;
    EXPECT_TRUE(report->warnings.empty());
    const auto session = open_session(scratch / "out");
    ASSERT_TRUE(session) << session.error().sentence;
    ASSERT_EQ(session->streams.size(), 2U);
    expect_same_frames(*session, frames);
    EXPECT_TRUE(session->truth);
    const auto background = read_background(*session);
    ASSERT_TRUE(background) << background.error().sentence;
    EXPECT_EQ((*background)[0].has_value(), fs::exists(frames / "background/left.png"));
}

}  // namespace
}  // namespace deixis
