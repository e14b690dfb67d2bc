// The PLY walk: every cut of a good file is refused, and so is whatever does not fit its header.
#include "appliance/parts/ply_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace deixis {
namespace {

using testing::HasSubstr;

std::string complaint(const std::string& bytes) {
    const auto checked = check_ply(bytes, "m.ply");
    return checked ? "" : checked.error().sentence;
}

std::string header(const std::string& format) {
    return "ply\nformat " + format +
           " 1.0\ncomment x\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
}

const std::string corners = "0 0 0\n5 +0 0\n-0 5e2 0\n";

TEST(PlyCheckTest, AcceptsWholeFilesOfEveryEncoding) {
    EXPECT_EQ(complaint(header("ascii") + corners + "3 0 1 2\n"), "");
    EXPECT_EQ(complaint(header("ascii") + corners + "3 0 1 2"), "") << "no line end at the end";
    std::string crlf = header("ascii") + corners + "3 0 1 2\n";
    for (size_t at = 0; (at = crlf.find('\n', at)) != std::string::npos; at += 2) crlf.insert(at, 1, '\r');
    EXPECT_EQ(complaint(crlf), "");
    const std::string zeros(36, '\0');
    EXPECT_EQ(
        complaint(header("binary_little_endian") + zeros + std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13)),
        "");
    EXPECT_EQ(complaint(header("binary_big_endian") + zeros + std::string("\3\0\0\0\0\0\0\0\1\0\0\0\2", 13)),
              "");
}

TEST(PlyCheckTest, RefusesEveryCut) {
    const std::string text = header("ascii") + corners + "3 0 1 2";
    for (size_t size = 0; size < text.size(); ++size)
        EXPECT_THAT(complaint(text.substr(0, size)), HasSubstr("m.ply: the mesh cannot be read (")) << size;
    const std::string bytes = header("binary_little_endian") + std::string(36, '\0') +
                              std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
    for (size_t size = 0; size < bytes.size(); ++size)
        EXPECT_THAT(complaint(bytes.substr(0, size)), HasSubstr("m.ply: the mesh cannot be read (")) << size;
}

TEST(PlyCheckTest, RefusesWhatDoesNotFitTheHeader) {
    EXPECT_EQ(complaint(header("ascii") + corners + "3 0 1 3"),
              "m.ply: the mesh cannot be read (face 0 of 1 has a corner that is no vertex).");
    EXPECT_EQ(complaint(header("ascii") + corners + "3 0 1 -1"),
              "m.ply: the mesh cannot be read (face 0 of 1 has a corner that is no vertex).");
    EXPECT_EQ(complaint(header("ascii") + "0 0 0\n5 x 0\n0 5 0\n3 0 1 2"),
              "m.ply: the mesh cannot be read (vertex 1 of 3 is cut short or damaged).");
    EXPECT_EQ(complaint(header("ascii") + corners + "-3 0 1 2"),
              "m.ply: the mesh cannot be read (face 0 of 1 is cut short or damaged).");
    // Each element has its own line: a reader that goes by lines would see other counts.
    EXPECT_EQ(complaint(header("ascii") + "0 0 0\n5 0 0\n0 5\n0\n3 0 1 2\n"),
              "m.ply: the mesh cannot be read (vertex 2 of 3 is cut short or damaged).");
    EXPECT_THAT(complaint("ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n"),
                HasSubstr("line 3"));
    EXPECT_THAT(complaint("ply\nformat ascii 2.0\n"), HasSubstr("line 2"));
    EXPECT_THAT(complaint("ply\nformat ascii 1.0\nproperty float x\n"), HasSubstr("line 3"));
    EXPECT_THAT(complaint("ply\nformat ascii 1.0\nelement vertex 9\nelement face 1\nend_header\n"),
                HasSubstr("has no property"));
}

}  // namespace
}  // namespace deixis
