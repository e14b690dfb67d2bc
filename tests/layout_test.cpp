// Holds the layout of the tree: the top level, names, first lines, sizes, and nothing of one machine in it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "tests/source_files.h"

namespace deixis {
namespace {

std::vector<std::string> files_matching(const std::string& pattern) {
    std::vector<std::string> found;
    const std::regex wanted(pattern);
    for (const std::string& file : source_files()) {
        if (std::regex_search(file, wanted)) found.push_back(file);
    }
    return found;
}

/// "file:line: text" of every line that matches, in the files of the endings.
std::vector<std::string> lines_matching(const std::string& pattern, const std::vector<std::string>& endings) {
    std::vector<std::string> found;
    const std::regex wanted(pattern);
    for (const std::string& file : source_files()) {
        if (!ends_in(file, endings)) continue;
        const std::vector<std::string> lines = lines_of(file);
        for (size_t i = 0; i < lines.size(); ++i) {
            if (!std::regex_search(lines[i], wanted)) continue;
            found.push_back(file + ":" + std::to_string(i + 1) + ": " + lines[i].substr(0, 120));
        }
    }
    return found;
}

const std::vector<std::string> code = {".h",   ".cpp",  ".ts", ".mjs", ".css", ".html",
                                       ".txt", ".toml", ".py", "/run", "/demo"};

TEST(Layout, TopLevelHoldsTheHouseAndNothingElse) {
    const std::set<std::string> house = {"CMakeLists.txt", "tracking", "gestures",  "appliance", "hmi",
                                         "deploy",         "tests",    "README.md", "LICENSE"};
    std::set<std::string> seen;
    for (const std::string& file : source_files()) seen.insert(file.substr(0, file.find('/')));
    for (const std::string& entry : seen)
        EXPECT_TRUE(entry.starts_with(".") || house.contains(entry)) << entry;
    for (const std::string& entry : house) EXPECT_TRUE(seen.contains(entry)) << entry << " is missing";
}

TEST(Layout, NothingIsADrawer) {
    EXPECT_THAT(files_matching("(^|/)(utils?|common|helpers?|misc)(/|\\.|_|$)"), testing::IsEmpty());
}

TEST(Layout, EverySourceOpensWithTheIdeaItOwns) {
    for (const std::string& file : source_files()) {
        if (!ends_in(file, {".h", ".cpp", ".ts", ".mjs", ".css", ".html"})) continue;
        const std::vector<std::string> lines = lines_of(file);
        const std::string first = lines.empty() ? "" : lines[0];
        const bool comment = first.starts_with("// ") || first.starts_with("/* ") || first.starts_with("<!");
        EXPECT_TRUE(comment) << file << " opens with: " << first;
    }
}

TEST(Layout, HeadersAreGuardedByPragma) {
    for (const std::string& file : source_files()) {
        if (!file.ends_with(".h")) continue;
        EXPECT_THAT(lines_of(file), testing::Contains("#pragma once")) << file;
    }
}

TEST(Layout, NoFileIsLong) {
    for (const std::string& file : source_files()) {
        const bool prose = !ends_in(file, {".h", ".cpp", ".ts"});
        EXPECT_TRUE(prose || lines_of(file).size() <= 450) << file;
        EXPECT_LE(std::filesystem::file_size(source_root() / file), 1'000'000U) << file;
    }
}

TEST(Layout, NothingIsUnfinished) {
    // Built from pieces so that these lines do not find themselves.
    const std::string words =
        std::string("TO") + "DO|FIX" + "ME|\\bXX" + "X\\b|HA" + "CK|not imple" + "mented|DISAB" + "LED_";
    EXPECT_THAT(lines_matching(words, code), testing::IsEmpty());
}

TEST(Layout, NothingIsTiedToOneMachine) {
    const std::string paths = std::string("/(wor") + "k|hom" + "e|roo" + "t)/[A-Za-z.]";
    EXPECT_THAT(lines_matching(paths, code), testing::IsEmpty());
    EXPECT_THAT(lines_matching(std::string("-mar") + "ch=", code), testing::IsEmpty());
}

TEST(Layout, ScriptsCanBeRun) {
    for (const char* script : {".ci/run", "tests/run", "deploy/demo", "deploy/install-packages"}) {
        const auto permissions = std::filesystem::status(source_root() / script).permissions();
        EXPECT_NE(permissions & std::filesystem::perms::owner_exec, std::filesystem::perms::none) << script;
    }
}

}  // namespace
}  // namespace deixis
