// Station and PLC over a whole session. A defect is booked to the part that the PLC names, and to none once
// that part has left; its time is the session's own, wherever the session's clock began. A PLC that slept
// gets every defect, once.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>

#include "tests/acceptance/watched_program.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;

struct Booked {
    std::string type, serial;
    int64_t time_us = 0;
};

std::vector<Booked> booked_in(const std::string& database) {
    std::vector<Booked> all;
    SQLite::Database record(database, SQLite::OPEN_READWRITE);
    SQLite::Statement query(record,
                            "SELECT type, serial, time_us FROM defect JOIN part ON part.id = defect.part "
                            "ORDER BY defect.id");
    while (query.executeStep())
        all.push_back(
            {query.getColumn(0).getString(), query.getColumn(1).getString(), query.getColumn(2).getInt64()});
    return all;
}

/// The session again, its clock begun 54 years before it was made.
void link_session_with_other_clock(const fs::path& session, const fs::path& to) {
    fs::create_directories(to);
    for (const auto& entry : fs::directory_iterator(session))
        if (entry.path().filename() != "session.toml")
            fs::create_symlink(fs::absolute(entry.path()), to / entry.path().filename());
    std::ifstream in(session / "session.toml");
    std::ofstream out(to / "session.toml");
    for (std::string line; std::getline(in, line);) {
        std::smatch start;
        if (std::regex_match(line, start, std::regex(R"(start_us = (-?\d+))")))
            line = "start_us = " + std::to_string(std::stoll(start[1]) + 1'700'000'000'000'000);
        out << line << '\n';
    }
}

TEST(PartNamedByPlc, GetsTheDefectsMadeWhileItStandsThere) {
    const char* session = std::getenv("DEIXIS_SESSION");
    const char* source = std::getenv("DEIXIS_SOURCE");
    ASSERT_TRUE(session != nullptr && source != nullptr);
    const std::string folder = testing::TempDir() + "/part_named_by_plc";
    fs::remove_all(folder);
    link_session_with_other_clock(session, folder + "/session");
    const std::string port = std::to_string(15'000 + getpid() % 1'000);
    std::ofstream(folder + "/settings.toml") << "[plc]\nmode = \"server\"\nport = " << port << "\n";

    WatchedProgram station({"deixis", "station", folder + "/session", "--settings", folder + "/settings.toml",
                            "--fast", "--exit-at-end", "--no-screen", "--database", folder + "/record.db"});
    const std::string said = folder + "/plc.txt";
    const std::string peer = std::string("/usr/bin/python3 ") + source +
                             "/tests/acceptance/plc_that_changes_parts.py " + port + " > " + said + " 2>&1";
    EXPECT_EQ(std::system(peer.c_str()), 0);
    EXPECT_EQ(station.wait(), 0) << testing::PrintToString(station.lines());

    std::ifstream plc(said);
    const std::string told{std::istreambuf_iterator<char>(plc), {}};
    EXPECT_EQ(told, "NAMED\nDEFECT SN-0042 count 1\nGONE count 0\n");
    EXPECT_THAT(
        station.lines(),
        testing::Contains("TROUBLE the PLC says that a part of type \"bumper-front-x\" is in the cell, "
                          "the station knows \"bumper-front-a\""));
    const std::vector<Booked> booked = booked_in(folder + "/record.db");
    ASSERT_GE(booked.size(), 2U);
    EXPECT_EQ(booked.front().type, "bumper-front-x");
    EXPECT_EQ(booked.front().serial, "SN-0042");
    EXPECT_EQ(booked.back().type, "bumper-front-a");
    EXPECT_EQ(booked.back().serial, "");
    constexpr int64_t made_us = 1'704'067'200'000'000;  // 2024-01-01, as the simulator writes
    for (const Booked& b : booked) {
        EXPECT_GT(b.time_us, made_us);
        EXPECT_LT(b.time_us, made_us + 60'000'000);
    }
    fs::remove_all(folder);
}

TEST(PlcThatWakesLate, GetsWhatItsQueueCouldNotHold) {
    const char* session = std::getenv("DEIXIS_SESSION");
    const char* source = std::getenv("DEIXIS_SOURCE");
    ASSERT_TRUE(session != nullptr && source != nullptr);
    const std::string folder = testing::TempDir() + "/plc_that_wakes_late";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string port = std::to_string(16'000 + getpid() % 1'000);
    std::ofstream(folder + "/settings.toml")
        << "[plc]\nmode = \"server\"\nqueue_length = 2\nport = " << port << "\n";
    const std::string database = folder + "/record.db", said = folder + "/plc.txt";
    // Marks of an earlier run, more than the queue holds.
    WatchedProgram earlier(
        {"deixis", "replay", session, "--results", folder + "/results.jsonl", "--database", database});
    ASSERT_EQ(earlier.wait(), 0);
    const auto is_mark = [](const std::string& line) { return line.starts_with("MARK "); };
    const auto made_by = [&](const WatchedProgram& program) {
        return std::count_if(program.lines().begin(), program.lines().end(), is_mark);
    };
    ASSERT_GE(made_by(earlier), 3);

    WatchedProgram station({"deixis", "station", session, "--settings", folder + "/settings.toml", "--fast",
                            "--screen-port", "0", "--database", database});
    const auto run = [&](const std::string& plc) {
        return std::system(
            ("timeout 15 /usr/bin/python3 " + (source + ("/" + plc)) + " " + port + " >> " + said).c_str());
    };
    // It makes room for one while older ones wait, and newer ones come.
    EXPECT_EQ(run("tests/acceptance/plc_that_echoes_once.py"), 0);
    ASSERT_TRUE(station.wait_for([](const std::string& line) { return line.starts_with("END "); },
                                 std::chrono::seconds(120)));
    const auto marks = made_by(earlier) + made_by(station);
    ASSERT_GT(marks, made_by(earlier));
    EXPECT_NE(run("deploy/demo-plc"), 0) << "it asks until its time is up";
    station.send(SIGTERM);
    EXPECT_EQ(station.wait(), 0) << testing::PrintToString(station.lines());

    std::ifstream plc(said);
    std::vector<std::string> took(1);
    std::getline(plc, took[0]);
    for (std::string line; std::getline(plc, line);)
        if (line.starts_with("PLC took defect ")) took.push_back(line.substr(16, line.find(" at") - 16));
    std::vector<std::string> expected;
    for (int id = 1; id <= marks; ++id) expected.push_back(std::to_string(id));
    EXPECT_EQ(took, expected) << "each once, in order";
    fs::remove_all(folder);
}

}  // namespace
}  // namespace deixis
