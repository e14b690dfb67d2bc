// Model files through the reader's process: the same bits as within this one, and one sentence for whatever
// ends it.
#include "appliance/parts/model_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "appliance/parts/model_file.h"
#include "appliance/parts/model_reader_child.h"
#include "appliance/parts/sample_bumper.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

class ModelReaderTest : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("deixis-model-reader-" + std::to_string(::getpid()));
        fs::create_directories(folder_);
        ASSERT_TRUE(fs::exists(deixis_.program)) << "DEIXIS_BIN must name the folder of `deixis`";
    }
    void TearDown() override { fs::remove_all(folder_); }

    fs::path written(const std::string& name, const std::string& bytes) {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
        return folder_ / name;
    }
    /// A reader that is the shell script `body`; its argument --reply=3 is open as file 3.
    ModelReader stand_in(const std::string& body, double seconds = 20) {
        const fs::path script = written("reader", "#!/bin/sh\n" + body + "\n");
        fs::permissions(script, fs::perms::owner_all);
        return {script, {.time_limit_s = seconds}};
    }
    std::string refusal(const fs::path& model, const ModelReader& reader) {
        const auto mesh = load_mesh(model, 0.001, reader);
        return mesh ? "accepted" : mesh.error().sentence;
    }

    fs::path folder_;
    ModelReader deixis_ = {fs::path(std::getenv("DEIXIS_BIN") ? std::getenv("DEIXIS_BIN") : "bin") /
                           "deixis"};
};

fs::path seed(const std::string& name) {
    const char* source = std::getenv("DEIXIS_SOURCE");
    return fs::path(source ? source : ".") / "tests/fuzz/corpus" / name;
}

const std::string obj = "v 0 0 0\nv 1000 0 0\nv 0 1000 0\nv 0 0 1000\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

void expect_same_bits(const Result<SurfaceMesh>& here, const Result<SurfaceMesh>& there) {
    ASSERT_TRUE(here) << here.error().sentence;
    ASSERT_TRUE(there) << there.error().sentence;
    ASSERT_EQ(here->vertices.size(), there->vertices.size());
    EXPECT_EQ(std::memcmp(here->vertices.data(), there->vertices.data(),
                          here->vertices.size() * sizeof here->vertices[0]),
              0);
    EXPECT_EQ(here->triangles, there->triangles);
}

TEST_F(ModelReaderTest, GivesTheBitsThatThisProcessWouldRead) {
    const fs::path bumper = folder_ / "bumper.step";
    ASSERT_TRUE(write_sample_bumper(SampleBumper::a, bumper));
    for (const fs::path& model : {bumper, seed("ply/ascii.ply"), seed("ply/little.ply"), seed("ply/big.ply"),
                                  written("t.obj", obj), written("-odd [1], \"2\" {3}.obj", obj)}) {
        SCOPED_TRACE(model.string());
        expect_same_bits(read_model_file(model, 0.001), load_mesh(model, 0.001, deixis_));
    }
    const fs::path third = folder_ / "t.obj";
    expect_same_bits(read_model_file(third, 1e-3 / 3), load_mesh(third, 1e-3 / 3, deixis_));
}

TEST_F(ModelReaderTest, RefusesWithTheSentencesOfThisProcess) {
    for (const fs::path& model : {folder_ / "none.step", written("e.step", ""), written("e.ply", ""),
                                  written("g.stl", "no mesh at all"), written("x.fbx", "abc"), folder_,
                                  written("km.obj", "v 0 0 0\nv 1e9 0 0\nv 0 1e9 0\nf 1 2 3\n")}) {
        const auto here = read_model_file(model, 0.001);
        ASSERT_FALSE(here) << model;
        EXPECT_EQ(refusal(model, deixis_), here.error().sentence);
    }
    EXPECT_THAT(load_mesh(written("t.obj", obj), std::nan(""), deixis_).error().sentence,
                EndsWith("the unit must be a positive length, got nan m."));
}

std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST_F(ModelReaderTest, SurvivesTheFilesThatStopTheLibraries) {
    const auto whole = load_mesh(seed("step/faceted.step"), 0.001, deixis_);
    ASSERT_TRUE(whole) << whole.error().sentence;
    EXPECT_EQ(whole->triangles.size(), 4U);
    // Open CASCADE 7.6 reads through a null pointer on each of these.
    for (const auto& [good, bad] : {std::pair<std::string, std::string>{"('',#23,.T.)", "('',#x3,.T.)"},
                                    {"POLY_LOOP('',(#31", "PNLY_LOOP('',(#31"},
                                    {"#33=CARTESIAN", "#33=CAPTESIAN"},
                                    {"3D('',#30,#36,#38)", "3D(7',#30,#36,#38)"}}) {
        std::string text = bytes_of(seed("step/faceted.step"));
        ASSERT_NE(text.find(good), std::string::npos);
        text.replace(text.find(good), good.size(), bad);
        const fs::path damaged = written("damaged.step", text);
        const std::string sentence = refusal(damaged, deixis_);
        EXPECT_THAT(sentence, AllOf(StartsWith(damaged.string() + ": "), HasSubstr("damaged"))) << bad;
    }
    // Assimp 5.2 never ends on the first of these and reads beyond its memory on the second.
    for (const char* name : {"ply/ascii.ply", "ply/little.ply"})
        for (const size_t share : {40, 85}) {
            const std::string text = bytes_of(seed(name));
            const fs::path cut = written("cut.ply", text.substr(0, text.size() * share / 100));
            EXPECT_THAT(refusal(cut, {deixis_.program, {.time_limit_s = 5}}), StartsWith(cut.string() + ": "))
                << name << " at " << share << " %";
        }
}

TEST_F(ModelReaderTest, SaysHowTheReaderEnded) {
    const fs::path model = written("bumper.step", "ISO-10303-21;");
    const std::string stem = model.string() + ": the model reader ";
    EXPECT_EQ(refusal(model, stand_in("kill -SEGV $$")),
              stem + "crashed on it (signal 11, Segmentation fault); is the file damaged?");
    EXPECT_EQ(refusal(model, stand_in("exit 7")), stem + "gave up on it (code 7); is the file damaged?");
    EXPECT_EQ(refusal(model, stand_in("exit 0")), stem + "ended without an answer.");
    EXPECT_EQ(refusal(model, stand_in("printf short >&3")), stem + "ended without an answer.");
    EXPECT_EQ(refusal(model, stand_in("head -c 4000 /dev/zero >&3")), stem + "gave no sensible answer.");
    EXPECT_THAT(refusal(model, {folder_ / "no-program"}),
                AllOf(StartsWith((folder_ / "no-program").string() + ": cannot be started to read " +
                                 model.string() + ": No such file"),
                      EndsWith(".")));
}

TEST_F(ModelReaderTest, DoesNotWaitLongerThanItsLimit) {
    const fs::path model = written("t.obj", obj);
    const std::string late =
        ": the model reader was not done after 0.3 s; is the file damaged, or far too fine?";
    const auto start = std::chrono::steady_clock::now();
    // Silent, busy, deaf to SIGTERM, stuck in the middle of a reply, and with the pipe held by a grandchild.
    for (const char* body : {"sleep 60", "while :; do :; done", "trap '' TERM; while :; do :; done",
                             "printf abc >&3; sleep 60", "sleep 5 & exit 0"})
        EXPECT_EQ(refusal(model, stand_in(body, 0.3)), model.string() + late) << body;
    EXPECT_EQ(refusal(model, {deixis_.program, {.time_limit_s = 0.001}}),
              model.string() +
                  ": the model reader was not done after 0.001 s; is the file damaged, or far too fine?");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(15));
}

/// What the child writes when it means harm, as bytes for file 3.
std::string reply_bytes(const std::array<uint64_t, 4>& head, const std::string& rest = "") {
    return std::string(reinterpret_cast<const char*>(head.data()), sizeof head) + rest;
}

TEST_F(ModelReaderTest, BelievesNothingUnchecked) {
    constexpr uint64_t mark = ModelReplyHead::right_mark, many = uint64_t{1} << 60;
    const fs::path model = written("t.obj", obj);
    const std::string stem = model.string() + ": ";
    const auto told = [&](const std::string& bytes) {
        const fs::path reply = written("reply", bytes);
        return refusal(model, stand_in("exec cat '" + reply.string() + "' >&3"));
    };
    const std::string corners(9 * sizeof(float), '\0'), indices("\0\0\0\0\1\0\0\0\3\0\0\0", 12);
    EXPECT_EQ(told(reply_bytes({mark + 1, 0, 0, 0})), stem + "the model reader gave no sensible answer.");
    for (const auto& head :
         {std::array<uint64_t, 4>{mark, many, 0, 0}, {mark, 0, many, 0}, {mark, 0, 0, many}})
        EXPECT_EQ(told(reply_bytes(head)), stem + "the model reader gave no sensible answer.");
    EXPECT_EQ(told(reply_bytes({mark, 0, 3, 1}, corners)),
              stem + "the model reader ended without an answer.");
    EXPECT_EQ(told(reply_bytes({mark, 0, 3, 1}, corners + indices)),
              stem + "a triangle has a corner 3 of 3 vertices.");
    EXPECT_EQ(told(reply_bytes({mark, 0, 3, 1}, corners + indices + "more")),
              stem + "the model reader gave no sensible answer.");
    EXPECT_EQ(told(reply_bytes({mark, 0, 0, 0})), stem + "the file holds no triangle, expected a surface.");
    EXPECT_EQ(told(reply_bytes({mark, 5, 0, 0}, "a\nb\tc")), "a b c");
}

TEST_F(ModelReaderTest, LimitsAreChecked) {
    EXPECT_TRUE(ModelReaderParams{}.validate().empty());
    EXPECT_EQ((ModelReaderParams{0, 4096}).validate().size(), 1U);
    EXPECT_EQ((ModelReaderParams{60, 10}).validate().size(), 1U);
}

}  // namespace
}  // namespace deixis
