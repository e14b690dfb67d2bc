// A folder of its own for every test, and a mark to put into a ledger.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "appliance/records/defect_ledger.h"

namespace deixis {

class LedgerFolder : public ::testing::Test {
  protected:
    void SetUp() override {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ = root() / ("deixis-records-" + std::to_string(::getpid()) + "-" + test->name());
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        file_ = folder_ / "deixis.db";
    }
    /// In memory where that exists: what is tested here does not depend on how long a sync takes.
    virtual std::filesystem::path root() const {
        return std::filesystem::exists("/dev/shm") ? std::filesystem::path("/dev/shm")
                                                   : std::filesystem::temp_directory_path();
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path folder_, file_;
};

inline DefectRecord sample_record(int n = 1) {
    DefectRecord record;
    record.part_type = "bumper-front-a";
    record.part_serial = "0001";
    record.mark.timestamp_us = 33'333 * n;
    record.mark.spot.position = {0.31 + 0.001 * n, -0.02, 0.12};
    record.mark.spot.normal = {0, -1, 0};
    record.mark.arm = n % 2 == 0 ? ArmSide::left : ArmSide::right;
    record.mark.confidence = 0.875;
    record.mark.touch = n % 3 == 0;
    record.zone = "upper left";
    record.time_us = 1'763'800'000'000'000 + 1'000'000LL * n;
    return record;
}

inline std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace deixis
