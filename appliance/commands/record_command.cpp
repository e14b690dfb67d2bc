// `deixis record`: live sensors into a session folder, or an interrupted recording made whole.
#include <iomanip>
#include <iostream>

#include "appliance/calibration/calibration_file.h"
#include "appliance/commands/commands.h"
#include "appliance/commands/live_recording.h"
#include "appliance/commands/program_path.h"
#include "appliance/commands/refusal.h"
#include "appliance/commands/stop_signal.h"
#include "appliance/records/utc_time.h"

namespace deixis {
namespace {

struct RecordOptions {
    std::filesystem::path out, calibration, part, settings, driver_folder;
    double seconds = 0, wait = 20;
    bool mend = false;
};

void print_table(const std::vector<RecordedSensor>& sensors, const std::filesystem::path& out) {
    std::cout << std::left << std::setw(16) << "sensor" << std::right << std::setw(10) << "frames"
              << std::setw(10) << "dropped" << std::setw(10) << "refused" << std::setw(10) << "restarts"
              << '\n';
    for (const RecordedSensor& s : sensors)
        std::cout << std::left << std::setw(16) << s.name << std::right << std::setw(10) << s.frames
                  << std::setw(10) << s.health.dropped << std::setw(10) << s.health.corrupt << std::setw(10)
                  << s.health.restarts << '\n';
    std::cout << "recorded " << out.string() << '\n';
}

Result<void> mend(const std::filesystem::path& out) {
    const auto mended = mend_session(out.string() + ".recording");
    if (!mended) return tl::unexpected(mended.error());
    std::cout << "mended " << mended->string() << '\n';
    return {};
}

Result<void> record(const RecordOptions& options) {
    if (options.calibration.empty())
        return fail("--calibration FILE is missing: which sensors shall be recorded?");
    const auto calibration = read_calibration(options.calibration);
    if (!calibration) return tl::unexpected(calibration.error());
    for (const std::string& warning : calibration->warnings)
        std::cerr << "deixis record: warning: " << warning << '\n';
    const SensorRig& rig = calibration->rig;
    const auto out = options.out.has_filename() ? options.out : options.out.parent_path();

    // The folder first: what cannot be written must show before a worker has been asked to move.
    auto writer = SessionWriter::create(
        out, rig, {out.filename().string(), utc_text(utc_now_us()), {{"deixis", DEIXIS_VERSION}}});
    if (!writer) return tl::unexpected(writer.error());
    const auto discard = [&](const Failure& failure) -> Result<void> {
        const std::filesystem::path working = writer->working_folder();
        std::error_code ignored;
        std::filesystem::remove_all(working, ignored);
        return tl::unexpected(failure);
    };
    if (auto copied = writer->copy_calibration(options.calibration); !copied) return discard(copied.error());
    if (!options.part.empty())
        if (auto copied = writer->copy_part(options.part); !copied) return discard(copied.error());
    if (!options.settings.empty())
        if (auto copied = writer->copy_settings(options.settings); !copied) return discard(copied.error());

    catch_stop_signals();
    LiveRecordingParams params;
    params.program = program_path();
    params.driver_folder = options.driver_folder;
    params.seconds = options.seconds;
    params.wait_seconds = options.wait;
    auto recording = LiveRecording::start(rig, params, stop_requested);
    if (!recording) return discard(recording.error());
    std::cout << "recording" << std::endl;
    auto ran = recording->run(*writer, stop_requested, [](const std::string& sentence) {
        std::cerr << "deixis record: " << sentence << '\n';
    });
    recording->end();
    if (auto finished = writer->finish(); !finished) return ran ? finished : ran;
    print_table(recording->sensors(), out);
    return ran;
}

}  // namespace

void add_record_command(CLI::App& app) {
    static RecordOptions options;
    CLI::App* command = app.add_subcommand("record", "Record the live sensors into a session folder");
    command->add_option("OUT", options.out, "session folder to write; must not exist")->required();
    command->add_option("--calibration", options.calibration,
                        "calibration.toml whose sensors name their devices (uri)");
    command->add_option("--seconds", options.seconds, "how long; without it until Ctrl-C")
        ->check(CLI::PositiveNumber);
    command->add_option("--wait", options.wait, "how many seconds to wait for the sensors to come up")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    command->add_option("--part", options.part, "part.toml to keep with the session");
    command->add_option("--settings", options.settings, "station settings to keep with the session");
    command->add_option("--driver-folder", options.driver_folder,
                        "private OpenNI2 folder, e.g. of the virtual sensors; without it the system's");
    command->add_flag("--mend", options.mend,
                      "make OUT of what an interrupted recording left as OUT.recording");
    command->callback([] {
        const auto done = options.mend ? mend(options.out) : record(options);
        if (!done) refuse(done.error(), "deixis record: ");
    });
}

}  // namespace deixis
