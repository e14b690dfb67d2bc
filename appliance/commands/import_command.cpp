// `deixis import FRAMES OUT`: a frames folder from anywhere becomes a session. `deixis mend`: an interrupted
// one as well.
#include <chrono>
#include <ctime>
#include <string>

#include "appliance/commands/commands.h"
#include "appliance/commands/program_path.h"
#include "appliance/commands/refusal.h"
#include "appliance/parts/model_reader.h"
#include "appliance/parts/part_model.h"
#include "appliance/sessions/import_frames.h"
#include "appliance/sessions/session_writer.h"

namespace deixis {
namespace {

struct ImportArguments {
    std::string frames;
    std::string out;
    std::string name;
};

std::string utc_now() {
    const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    std::tm utc = {};
    ::gmtime_r(&now, &utc);
    std::string text(32, '\0');
    text.resize(std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc));
    return text;
}

/// A part that the station could not load later is refused now.
void check_part_loads(const std::filesystem::path& part_toml) {
    std::error_code error;
    if (!std::filesystem::exists(part_toml, error)) return;
    const Result<PartFile> part = read_part_file(part_toml);
    if (!part) refuse(part.error());
    for (const std::string& warning : part->warnings) std::fprintf(stderr, "%s\n", warning.c_str());
    if (const auto mesh = load_mesh(part->model, part->metres_per_unit, {program_path()}); !mesh)
        refuse(mesh.error());
}

void run_import(const ImportArguments& arguments) {
    check_part_loads(std::filesystem::path(arguments.frames) / "part.toml");
    const SessionOrigin origin = {arguments.name, utc_now(), {{"deixis", DEIXIS_VERSION}}};
    const Result<ImportReport> report = import_frames(arguments.frames, arguments.out, origin);
    if (!report) refuse(report.error());
    for (const std::string& warning : report->warnings) std::fprintf(stderr, "%s\n", warning.c_str());
    std::string counts;
    for (const int64_t frames : report->frames)
        counts += (counts.empty() ? "" : " + ") + std::to_string(frames);
    std::printf("%s: %s frames\n", arguments.out.c_str(), counts.c_str());
}

}  // namespace

void add_import_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("import", "make a session of a folder of PNG frames");
    auto arguments = std::make_shared<ImportArguments>();
    command
        ->add_option("FRAMES", arguments->frames, "frames folder: calibration.toml and one folder a sensor")
        ->required();
    command->add_option("OUT", arguments->out, "session folder to make; must not exist")->required();
    command->add_option("--name", arguments->name, "name of the session; the frames folder's by default");
    command->callback([arguments] { run_import(*arguments); });
}

void add_mend_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("mend", "make a session of a recording that was interrupted");
    auto folder = std::make_shared<std::string>();
    command->add_option("FOLDER", *folder, "the OUT.recording folder that was left behind")->required();
    command->callback([folder] {
        const Result<std::filesystem::path> session = mend_session(*folder);
        if (!session) refuse(session.error());
        std::printf("%s\n", session->c_str());
    });
}

}  // namespace deixis
