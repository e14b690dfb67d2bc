// `deixis replay`: a session through the station in lock-step; one line of results a frameset.
#include <unistd.h>

#include <iostream>
#include <memory>

#include "appliance/commands/commands.h"
#include "appliance/commands/program_path.h"
#include "appliance/commands/refusal.h"
#include "appliance/commands/results_writer.h"
#include "appliance/commands/station_log.h"
#include "appliance/commands/stop_signal.h"
#include "appliance/station/station.h"

namespace deixis {
namespace {

struct ReplayOptions {
    std::filesystem::path session, results, database;
    int threads = 0;
    bool quiet = false;
};

/// A record of its own in a folder that goes away with the run, unless the user wants to keep it.
class FreshRecord {
  public:
    static Result<FreshRecord> make(const std::filesystem::path& wanted) {
        if (!wanted.empty()) {
            if (std::filesystem::exists(wanted))
                return fail(wanted.string() +
                            ": exists, expected a new file: a replay starts from a fresh record");
            return FreshRecord(wanted, {});
        }
        std::string pattern = (std::filesystem::temp_directory_path() / "deixis-replay-XXXXXX").string();
        if (!mkdtemp(pattern.data()))
            return fail(pattern + ": no temporary folder can be made for the record");
        return FreshRecord(std::filesystem::path(pattern) / "record.db", pattern);
    }
    FreshRecord(FreshRecord&& other) noexcept
        : database_(std::move(other.database_)), folder_(std::move(other.folder_)) {
        other.folder_.clear();
    }
    FreshRecord& operator=(FreshRecord&&) = delete;
    ~FreshRecord() {
        std::error_code ignored;
        if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
    }
    const std::filesystem::path& database() const { return database_; }

  private:
    FreshRecord(std::filesystem::path database, std::filesystem::path folder)
        : database_(std::move(database)), folder_(std::move(folder)) {}
    std::filesystem::path database_, folder_;
};

/// The session's own settings, else the program's defaults; never those of this machine (formats.md).
Result<Settings> session_settings(const std::filesystem::path& session) {
    const std::filesystem::path own = session / "settings.toml";
    if (!std::filesystem::exists(own)) return Settings{};
    auto file = read_settings(own);
    if (!file) return tl::unexpected(file.error());
    for (const std::string& warning : file->warnings)
        std::cerr << "deixis replay: warning: " << warning << '\n';
    return file->settings;
}

Result<void> complain_if_short(const StationState& state) {
    for (const SensorHealth& sensor : state.sensors)
        if (sensor.state != SensorState::finished)
            return fail("sensor " + sensor.name + " " + name_of(sensor.state) + ": " + sensor.reason);
    if (state.framesets < state.expected)
        return fail("only " + std::to_string(state.framesets) + " of " + std::to_string(state.expected) +
                    " framesets came");
    if (!state.last_trouble.empty()) return fail(state.last_trouble);
    return {};
}

Result<void> play(Station& station, ResultsWriter& results, StationLog& log) {
    for (;;) {
        if (stop_requested()) return fail("stopped by a signal before the end of the session");
        const Station::Turn turn = station.turn(std::chrono::milliseconds(500));
        if (turn == Station::Turn::finished) break;
        const bool fresh = turn == Station::Turn::frame;
        if (fresh) results.add(station.result());
        log.tell(station, fresh);
    }
    return complain_if_short(station.state());
}

Result<void> replay(const ReplayOptions& options) {
    const Progress progress = [&](const std::string& what, double share) {
        if (!options.quiet)
            std::cout << "PROGRESS " << what << ' ' << static_cast<int>(100 * share) << " %\n" << std::flush;
    };
    auto settings = session_settings(options.session);
    if (!settings) return tl::unexpected(settings.error());
    if (options.threads > 0) settings->perception.threads = options.threads;
    auto cell = work_cell_of_session(options.session, settings->reference, {program_path(), settings->model},
                                     progress);
    if (!cell) return tl::unexpected(cell.error());
    for (const std::string& warning : cell->warnings)
        std::cerr << "deixis replay: warning: " << warning << '\n';
    auto record = FreshRecord::make(options.database);
    if (!record) return tl::unexpected(record.error());

    auto results = ResultsWriter::create(options.results);
    if (!results) return tl::unexpected(results.error());

    StationSetup setup;
    setup.cell = std::move(*cell);
    setup.settings = *settings;
    setup.database = record->database();
    setup.program = program_path();
    setup.lock_step = true;
    setup.plc = false;
    auto station = Station::start(std::move(setup));
    if (!station) return tl::unexpected(station.error());
    StationLog log(!options.quiet);
    auto played = play(**station, *results, log);
    log.summary(**station);
    if (!played) return played;
    return results->finish();
}

}  // namespace

void add_replay_command(CLI::App& app) {
    auto* command =
        app.add_subcommand("replay", "play a session through the station in lock-step and write its results");
    auto options = std::make_shared<ReplayOptions>();
    command->add_option("session", options->session, "session folder")->required();
    command->add_option("--results", options->results, "results.jsonl to write, one object a frameset")
        ->required();
    command->add_option("--database", options->database, "keep the record in this new file");
    command
        ->add_option("--threads", options->threads, "threads at most (results are the same for any number)")
        ->check(CLI::Range(1, 64));
    command->add_flag("--quiet", options->quiet, "no progress lines");
    command->callback([options] {
        catch_stop_signals();
        if (const auto done = replay(*options); !done) refuse(done.error(), "deixis replay: ");
    });
}

}  // namespace deixis
