// A file is replaced whole or not at all, and nothing is left behind.
#include "appliance/calibration/whole_file.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

namespace deixis {
namespace {

namespace fs = std::filesystem;

class WholeFileTest : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("deixis-whole-" + std::to_string(::getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    static std::string bytes_of(const fs::path& file) {
        std::ifstream stream(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
    fs::path folder_;
};

TEST_F(WholeFileTest, ReplacesWhatWasThere) {
    const std::string text("a\0b\r\n", 5);
    ASSERT_TRUE(write_whole_file(folder_ / "out.csv", "older and longer"));
    ASSERT_TRUE(write_whole_file(folder_ / "out.csv", text));
    EXPECT_EQ(bytes_of(folder_ / "out.csv"), text);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1)
        << "nothing left behind";
}

TEST_F(WholeFileTest, RefusesWhatCannotBeWritten) {
    EXPECT_EQ(write_whole_file(folder_, "x").error().sentence,
              folder_.string() + ": cannot be written: Is a directory");
    EXPECT_EQ(write_whole_file(folder_ / "no" / "out.csv", "x").error().sentence,
              (folder_ / "no" / "out.csv").string() + ": cannot be written: No such file or directory");
    EXPECT_EQ(write_whole_file(folder_ / std::string(300, 'x'), "x").error().sentence,
              (folder_ / std::string(300, 'x')).string() + ": cannot be written: File name too long");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 0);
}

TEST_F(WholeFileTest, AFailedWriteLeavesTheOldFile) {
    const fs::path path = folder_ / "kept.txt";
    ASSERT_TRUE(write_whole_file(path, "old"));
    fs::create_directory(path.string() + ".new");  // stands where the new file would be written
    EXPECT_EQ(write_whole_file(path, "new").error().sentence,
              path.string() + ": cannot be written: Is a directory");
    EXPECT_EQ(*read_whole_file(path, 10), "old");
    fs::remove(path.string() + ".new");
    ASSERT_TRUE(write_whole_file(path, "new"));
    EXPECT_EQ(*read_whole_file(path, 3), "new");
    EXPECT_EQ(read_whole_file(path, 2).error().sentence, path.string() + ": expected at most 2 bytes");
}

}  // namespace
}  // namespace deixis
