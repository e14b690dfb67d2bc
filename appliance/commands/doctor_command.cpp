// `deixis doctor`: looks at all that a station needs and says what to do about what is wrong.
#include <gnu/libc-version.h>

#include <iostream>

#include "appliance/commands/commands.h"
#include "appliance/commands/doctor_checks.h"
#include "appliance/commands/program_path.h"

namespace deixis {
namespace {

struct DoctorOptions {
    std::string session, settings, database;
    bool json = false;
};

/// Program defaults where no file is named or the named one is refused.
Settings checked_settings(DoctorReport& report, const std::string& file) {
    if (file.empty()) return {};
    const auto read = read_settings(file);
    if (!read) {
        report.fail("settings", read.error().sentence, "mend the file; the checks below use the defaults");
        return {};
    }
    report.ok("settings", file);
    for (const std::string& warning : read->warnings)
        report.warn("settings", warning, "check the spelling of the key");
    return read->settings;
}

DoctorReport examine(const DoctorOptions& options) {
    DoctorReport report;
    report.ok("versions", std::string("deixis ") + DEIXIS_VERSION + ", " + DefectLedger::library_version() +
                              ", " + PlcLink::library_version() + ", glibc " + gnu_get_libc_version());
    const Settings settings = checked_settings(report, options.settings);
    const ModelReader reader = {program_path(), settings.model};
    check_drivers(report, settings.station.driver_folder);
    check_usb(report, "/sys", "/dev");
    if (!options.session.empty()) check_session(report, options.session, reader);
    if (!options.settings.empty()) check_station_files(report, settings.station, reader);
    const std::filesystem::path database =
        options.database.empty() ? settings.station.database : options.database;
    check_record(report, database);
    check_disk(report, database.parent_path());
    check_shared_memory(report);
    if (settings.screen.enabled) {
        check_port(report, "screen", settings.screen.host, settings.screen.port, "screen.port");
        check_web(report, settings.screen.web_root.empty()
                              ? program_path().parent_path().parent_path() / "web"
                              : std::filesystem::path(settings.screen.web_root));
    }
    check_plc(report, settings.plc);
    return report;
}

}  // namespace

void add_doctor_command(CLI::App& app) {
    static DoctorOptions options;
    CLI::App* command =
        app.add_subcommand("doctor", "Check sensors, files, record, ports and disk; say what to do");
    command->add_option("--session", options.session, "a session folder to check, checksums and all");
    command->add_option("--settings", options.settings,
                        "settings.toml of the station; else the program's defaults");
    command->add_option("--database", options.database, "the record; else the one of the settings");
    command->add_flag("--json", options.json, "print the report as JSON");
    command->callback([] {
        const DoctorReport report = examine(options);
        std::cout << (options.json ? report.json() : report.text()) << std::flush;
        if (report.failed()) throw CLI::RuntimeError(1);
    });
}

}  // namespace deixis
