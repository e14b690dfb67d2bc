// `deixis export`, `deixis plc map` and `deixis doctor` as a person runs them.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "appliance/records/defect_ledger.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Outcome {
    int code;
    std::string said;
};

class RecordCommandsTest : public ::testing::Test {
  protected:
    void SetUp() override {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ =
            fs::temp_directory_path() / ("deixis-commands-" + std::to_string(::getpid()) + test->name());
        fs::create_directories(folder_);
        database_ = folder_ / "deixis.db";
    }
    void TearDown() override { fs::remove_all(folder_); }

    void fill(int marks) const {
        auto ledger = DefectLedger::open(database_).value();
        for (int n = 1; n <= marks; ++n) {
            DefectRecord record;
            record.part_type = "bumper";
            record.part_serial = n % 2 == 0 ? "=2+3" : "0001";
            record.time_us = 86'400'000'000LL * n;
            ASSERT_EQ(ledger.commit(record).value(), n);
        }
        ASSERT_TRUE(ledger.set_state(2, DefectState::withdrawn, "test", 0));
    }

    /// Both streams of `deixis ARGUMENTS`.
    static Outcome deixis(const std::string& arguments) {
        const char* bin = std::getenv("DEIXIS_BIN");
        const std::string command =
            "'" + std::string(bin != nullptr ? bin : "build/bin") + "/deixis' " + arguments + " 2>&1";
        FILE* program = ::popen(command.c_str(), "r");
        std::string said;
        char buffer[4096];
        for (size_t got = 0; (got = std::fread(buffer, 1, sizeof buffer, program)) > 0;)
            said.append(buffer, got);
        const int status = ::pclose(program);
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, said};
    }

    static std::string bytes_of(const fs::path& file) {
        std::ifstream stream(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }

    std::string from_database() const { return " --database '" + database_.string() + "'"; }

    fs::path folder_, database_;
};

TEST_F(RecordCommandsTest, ExportsToAFileAndToStandardOutputAlike) {
    fill(3);
    const fs::path file = folder_ / "out.csv";
    const Outcome printed = deixis("export --format csv" + from_database());
    const Outcome written = deixis("export --format csv --output '" + file.string() + "'" + from_database());
    EXPECT_EQ(printed.code, 0);
    EXPECT_EQ(written.code, 0);
    EXPECT_EQ(written.said, "");
    EXPECT_EQ(bytes_of(file), printed.said);
    EXPECT_THAT(printed.said, StartsWith("id,time,part_type,"));
    EXPECT_THAT(printed.said, HasSubstr(",bumper,'=2+3,"));
}

TEST_F(RecordCommandsTest, ExportsWhatTheFilterLeaves) {
    fill(4);
    const auto ids = [&](const std::string& options) {
        const Outcome outcome = deixis("export --format jsonl" + from_database() + options);
        EXPECT_EQ(outcome.code, 0) << outcome.said;
        std::vector<int> found;
        for (size_t at = 0, end = 0; (end = outcome.said.find('\n', at)) != std::string::npos; at = end + 1)
            found.push_back(nlohmann::json::parse(outcome.said.substr(at, end - at))["id"]);
        return found;
    };
    EXPECT_EQ(ids(""), (std::vector{1, 2, 3, 4}));
    EXPECT_EQ(ids(" --since 1970-01-03"), (std::vector{2, 3, 4}));
    EXPECT_EQ(ids(" --until 1970-01-04T01:00:00+01:00"), (std::vector{1, 2}));
    EXPECT_EQ(ids(" --serial 0001"), (std::vector{1, 3}));
    EXPECT_EQ(ids(" --state withdrawn"), (std::vector{2}));
    EXPECT_EQ(ids(" --source elsewhere"), std::vector<int>{});
    EXPECT_EQ(ids(" --type bumper --since 1970-01-04 --until 1970-01-05"), (std::vector{3}));
}

TEST_F(RecordCommandsTest, ExportRefusesInOneSentence) {
    fill(2);
    const auto refused = [&](const std::string& options) {
        const Outcome outcome = deixis("export " + options);
        EXPECT_EQ(outcome.code, 1) << options;
        return outcome.said;
    };
    EXPECT_EQ(refused("--format csv --database '" + (folder_ / "no.db").string() + "'"),
              "there is no record at " + (folder_ / "no.db").string() + "\n");
    EXPECT_EQ(refused("--format csv --since yesterday" + from_database()),
              "--since: \"yesterday\" is not a time: expected a date as 2026-11-22 or an RFC 3339 time as "
              "2026-11-22T10:12:13Z\n");
    EXPECT_EQ(refused("--format csv --fecod TOOLONG" + from_database()),
              "the code \"TOOLONG\" does not fit; expected 1 to 4 characters\n");
    EXPECT_THAT(refused("--format csv --output '" + folder_.string() + "'" + from_database()),
                HasSubstr("Is a directory"));
    EXPECT_THAT(refused("--format csv" + from_database() + " 2>&1 >/dev/full #"),
                HasSubstr("cannot write to standard output"));
    EXPECT_EQ(deixis("export --format xml" + from_database()).code, 2);
    EXPECT_EQ(deixis("export --format csv").code, 2);
    EXPECT_EQ(deixis("export --format csv --state lost" + from_database()).code, 2);
}

TEST_F(RecordCommandsTest, PrintsTheWiringSheet) {
    EXPECT_THAT(deixis("plc map").said, HasSubstr("| 6 | uint16 | `defect_sequence` |"));
    EXPECT_THAT(deixis("plc map --format csv").said,
                StartsWith("block,offset,registers,type,name,unit,meaning\r\n"));
}

nlohmann::json check_of(const Outcome& outcome, const std::string& subject, const std::string& finding) {
    const auto report = nlohmann::json::parse(outcome.said);
    for (const auto& check : report["checks"])
        if (check["subject"] == subject &&
            check["finding"].get<std::string>().find(finding) != std::string::npos)
            return check;
    ADD_FAILURE() << "no check of " << subject << " says " << finding << "\n" << outcome.said;
    return {{"verdict", ""}, {"advice", ""}};
}

TEST_F(RecordCommandsTest, DoctorSaysWhatIsThere) {
    fill(2);
    const Outcome outcome = deixis("doctor --json" + from_database());
    EXPECT_EQ(check_of(outcome, "versions", "SQLite 3.")["verdict"], "OK");
    EXPECT_EQ(check_of(outcome, "record", "2 defects, version 2 of the tables, whole")["verdict"], "OK");
    EXPECT_EQ(check_of(outcome, "sensor drivers", "libOniFile.so.0")["verdict"], "OK");
    EXPECT_EQ(check_of(outcome, "plc", "no PLC is configured")["verdict"], "OK");
    const auto report = nlohmann::json::parse(outcome.said);
    EXPECT_EQ(report["ok"].get<bool>(), outcome.code == 0);
    for (const auto& check : report["checks"])
        EXPECT_EQ(check["verdict"] == "OK", check["advice"] == "") << check;
}

TEST_F(RecordCommandsTest, DoctorFindsWhatIsWrongAndSaysWhatToDo) {
    std::ofstream(database_) << "this is no record";
    int port_holder = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    ASSERT_EQ(::bind(port_holder, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(port_holder, 1), 0);
    ASSERT_EQ(::getsockname(port_holder, reinterpret_cast<sockaddr*>(&address), &length), 0);
    const fs::path settings = folder_ / "settings.toml";
    std::ofstream(settings) << "[plc]\nmode = \"server\"\nport = " << ntohs(address.sin_port)
                            << "\n[screen]\nweb_root = \"" << (folder_ / "no-web").string()
                            << "\"\n[station]\ndriver_folder = \"" << (folder_ / "no-drivers").string()
                            << "\"\nnonsense = 1\n";
    const Outcome outcome = deixis("doctor --json --settings '" + settings.string() + "' --session '" +
                                   (folder_ / "no-session").string() + "'" + from_database());
    ::close(port_holder);
    EXPECT_EQ(outcome.code, 1);
    for (const auto& [subject, finding, advice] :
         std::vector<std::array<std::string, 3>>{{"record", "is not a Deixis record", "never delete it"},
                                                 {"plc", "cannot be had: Address already in use", "plc.port"},
                                                 {"screen page", "no-web/index.html", "screen.web_root"},
                                                 {"sensor drivers", "no-drivers", "station.driver_folder"},
                                                 {"session", "no-session", "record, simulate or import"}}) {
        const auto check = check_of(outcome, subject, finding);
        EXPECT_EQ(check["verdict"], "FAIL");
        EXPECT_THAT(check["advice"].get<std::string>(), HasSubstr(advice));
    }
    EXPECT_EQ(check_of(outcome, "settings", "nonsense")["verdict"], "WARN");
    EXPECT_EQ(bytes_of(database_), "this is no record");
}

TEST_F(RecordCommandsTest, DoctorNamesADriverThatOpenNI2PassesOver) {
    const fs::path drivers = folder_ / "lib/OpenNI2/Drivers";
    fs::create_directories(drivers);
    for (const char* name : {"OpenNI2/Drivers/libOniFile.so.0", "OpenNI2/Drivers/libPS1080.so.0",
                             "OpenNI2/Drivers/liborbbec.so", "libOpenNI2.so.0"})
        std::ofstream(folder_ / "lib" / name) << "library";
    fs::create_symlink("libPS1080.so.0", drivers / "libPS1080.so");
    fs::create_symlink("gone.so.0", drivers / "libgone.so.0");
    std::ofstream(drivers / "libgone.so") << "library";
    const fs::path settings = folder_ / "settings.toml";
    std::ofstream(settings) << "[station]\ndriver_folder = \"" << (folder_ / "lib").string() << "\"\n";
    const Outcome outcome = deixis("doctor --json --settings '" + settings.string() + "'" + from_database());
    for (const char* passed_over : {"liborbbec.so will be ignored", "libgone.so will be ignored"})
        EXPECT_EQ(check_of(outcome, "sensor drivers", passed_over)["verdict"], "WARN");
    EXPECT_EQ(check_of(outcome, "sensor drivers", "libPS1080.so.0")["verdict"], "OK");
    EXPECT_THAT(outcome.said, ::testing::Not(HasSubstr("libPS1080.so will be ignored")))
        << "it is the link of the one that is loaded";
}

TEST_F(RecordCommandsTest, DoctorPrintsALineACheckForPeople) {
    const Outcome outcome =
        deixis("doctor --settings '" + (folder_ / "no.toml").string() + "'" + from_database());
    EXPECT_EQ(outcome.code, 1);
    EXPECT_THAT(outcome.said, HasSubstr("FAIL  settings: "));
    EXPECT_THAT(outcome.said, HasSubstr("      -> mend the file"));
    EXPECT_THAT(outcome.said, HasSubstr("OK    record: there is none at " + database_.string() + " yet"));
    EXPECT_FALSE(fs::exists(database_)) << "looking makes no record";
}

}  // namespace
}  // namespace deixis
