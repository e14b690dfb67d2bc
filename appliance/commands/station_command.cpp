// `deixis station`: live sensors or a session at its own pace, with record, PLC and screen.
#include <poll.h>

#include <iostream>
#include <memory>
#include <optional>

#include "appliance/commands/commands.h"
#include "appliance/commands/program_path.h"
#include "appliance/commands/refusal.h"
#include "appliance/commands/results_writer.h"
#include "appliance/commands/screen_link.h"
#include "appliance/commands/station_log.h"
#include "appliance/commands/stop_signal.h"

namespace deixis {
namespace {

struct StationOptions {
    std::filesystem::path session, settings, calibration, part, background, database, driver_folder, results;
    int screen_port = -1;
    double seconds = 0;
    bool no_screen = false, fast = false, exit_at_end = false, print_settings = false;
};

Result<Settings> station_settings(const StationOptions& options) {
    std::filesystem::path path = options.settings;
    if (path.empty() && !options.session.empty() &&
        std::filesystem::exists(options.session / "settings.toml"))
        path = options.session / "settings.toml";
    Settings settings;
    if (!path.empty()) {
        auto file = read_settings(path);
        if (!file) return tl::unexpected(file.error());
        for (const std::string& warning : file->warnings)
            std::cerr << "deixis station: warning: " << warning << '\n';
        settings = file->settings;
    }
    const auto overwrite = [](std::string& setting, const std::filesystem::path& option) {
        if (!option.empty()) setting = option.string();
    };
    overwrite(settings.station.calibration, options.calibration);
    overwrite(settings.station.part, options.part);
    overwrite(settings.station.background, options.background);
    overwrite(settings.station.database, options.database);
    overwrite(settings.station.driver_folder, options.driver_folder);
    if (options.screen_port >= 0) settings.screen.port = options.screen_port;
    if (options.no_screen) settings.screen.enabled = false;
    return settings;
}

Result<WorkCell> cell_of(const StationOptions& options, const Settings& settings) {
    const ModelReader reader = {program_path(), settings.model};
    if (!options.session.empty())
        return work_cell_of_session(
            options.session, settings.reference, reader, [](const std::string& what, double share) {
                std::cout << "PROGRESS " << what << ' ' << static_cast<int>(100 * share) << " %\n"
                          << std::flush;
            });
    if (settings.station.calibration.empty())
        return fail(
            "neither a session nor a calibration is named, expected SESSION, --calibration FILE or "
            "station.calibration in the settings");
    return work_cell_of_files(settings.station.calibration, settings.station.part,
                              settings.station.background, settings.reference, reader);
}

Result<std::unique_ptr<ScreenLink>> screen_of(const Settings& settings, const WorkCell& cell) {
    if (!settings.screen.enabled) return std::unique_ptr<ScreenLink>();
    ScreenServerParams params;
    params.host = settings.screen.host;
    params.port = settings.screen.port;
    params.web_root = settings.screen.web_root.empty()
                          ? (program_path().parent_path().parent_path() / "web").string()
                          : settings.screen.web_root;
    return ScreenLink::start(params, cell, settings.station.database);
}

/// Whatever the PLC has not echoed within this time after the end of a session is delivered by the next
/// start.
constexpr std::chrono::seconds last_word_of_plc{3};

/// Lets the PLC take the last marks of a session that has been played.
void wait_for_plc(Station& station) {
    const auto deadline = std::chrono::steady_clock::now() + last_word_of_plc;
    while (station.state().plc.defects_waiting > 0 && !stop_requested() &&
           std::chrono::steady_clock::now() < deadline) {
        station.turn(std::chrono::milliseconds(0));
        poll(nullptr, 0, 20);
    }
}

/// Turns until the end, a signal, or the time given. After the end of a session the results get their name
/// and the screen stays until a signal.
Result<void> run_station(Station& station, ScreenLink* screen, ResultsWriter* results, StationLog& log,
                         const StationOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    bool finished = false;
    while (!stop_requested()) {
        if (options.seconds > 0 &&
            std::chrono::steady_clock::now() - start > std::chrono::duration<double>(options.seconds))
            break;
        const Station::Turn turn = station.turn(std::chrono::milliseconds(200));
        const bool fresh = turn == Station::Turn::frame;
        log.tell(station, fresh);
        if (screen) screen->show(station, fresh);
        if (results && fresh) results->add(station.result());
        if (turn != Station::Turn::finished) continue;
        if (!finished) wait_for_plc(station);
        poll(nullptr, 0, 200);  // nothing comes any more: only the screen is kept up
        if (finished) continue;
        finished = true;
        if (results) {
            if (auto named = results->finish(); !named) return named;
        }
        if (options.exit_at_end || !screen) return {};
        std::cout << "END of the session; the screen stays at " << screen->address() << " until Ctrl-C\n"
                  << std::flush;
    }
    return {};
}

Result<void> station(const StationOptions& options) {
    auto settings = station_settings(options);
    if (!settings) return tl::unexpected(settings.error());
    auto cell = cell_of(options, *settings);
    if (!cell) return tl::unexpected(cell.error());
    for (const std::string& warning : cell->warnings)
        std::cerr << "deixis station: warning: " << warning << '\n';

    std::optional<ResultsWriter> results;
    if (!options.results.empty()) {
        auto writer = ResultsWriter::create(options.results);
        if (!writer) return tl::unexpected(writer.error());
        results.emplace(std::move(*writer));
    }

    StationSetup setup;
    setup.settings = *settings;
    setup.database = settings->station.database;
    setup.program = program_path();
    setup.driver_folder = settings->station.driver_folder;
    setup.lock_step = !options.session.empty();
    setup.real_time = setup.lock_step && !options.fast;
    setup.cell = *cell;
    auto station = Station::start(std::move(setup));
    if (!station) return tl::unexpected(station.error());
    auto screen = screen_of(*settings, *cell);
    if (!screen) return tl::unexpected(screen.error());
    if (*screen) std::cout << "SCREEN " << (*screen)->address() << '\n' << std::flush;

    StationLog log(!options.session.empty());
    auto ran = run_station(**station, screen->get(), results ? &*results : nullptr, log, options);
    log.summary(**station);
    for (const std::string& sentence : (*station)->stop())
        std::cerr << "deixis station: " << sentence << '\n';
    if (!ran) return ran;
    if (const StationState state = (*station)->state(); state.marks_lost > 0)
        return fail(std::to_string(state.marks_lost) + " marks are lost: " + state.last_trouble);
    if (!options.session.empty())
        for (const SensorHealth& sensor : (*station)->state().sensors)
            if (sensor.state == SensorState::missing)
                return fail("sensor " + sensor.name + ": " + sensor.reason);
    return {};
}

}  // namespace

void add_station_command(CLI::App& app) {
    auto* command = app.add_subcommand("station", "run the station: live, or on a session at its own pace");
    auto options = std::make_shared<StationOptions>();
    command->add_option("session", options->session, "session folder; without it the station runs live");
    command->add_option("--settings", options->settings,
                        "settings.toml (default: the session's own, else defaults)");
    command->add_option("--calibration", options->calibration,
                        "live: calibration.toml, each sensor with its uri");
    command->add_option("--part", options->part, "live: part.toml of the part in production");
    command->add_option("--background", options->background,
                        "live: folder with <sensor>.png of the empty cell");
    command->add_option("--database", options->database, "the record (default: station.database, deixis.db)");
    command->add_option("--results", options->results,
                        "session: results.jsonl to write, one object a frameset, named so at its end");
    command->add_option("--driver-folder", options->driver_folder,
                        "private OpenNI2 folder, for virtual sensors");
    command
        ->add_option("--screen-port", options->screen_port, "loopback port of the screen, 0 = any free one")
        ->check(CLI::Range(0, 65535));
    command->add_flag("--no-screen", options->no_screen, "no screen");
    command->add_option("--seconds", options->seconds, "end after so many seconds")
        ->check(CLI::PositiveNumber);
    command->add_flag("--fast", options->fast, "session: as fast as it goes, not at its own pace");
    command->add_flag("--exit-at-end", options->exit_at_end,
                      "session: end with it, do not keep the screen up");
    command->add_flag("--print-settings", options->print_settings,
                      "print every setting with its default and end");
    command->callback([options] {
        if (options->print_settings) {
            Settings defaults;
            std::cout << "# settings.toml of a Deixis station: every default, commented out\n"
                      << describe_settings(settings_table(defaults));
            return;
        }
        catch_stop_signals();
        if (const auto done = station(*options); !done) refuse(done.error(), "deixis station: ");
    });
}

}  // namespace deixis
