// `deixis simulate`: joins the virtual cell with the session writer, or writes a frames folder to be
// imported.
#include <atomic>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "appliance/calibration/calibration_file.h"
#include "appliance/commands/commands.h"
#include "appliance/commands/program_path.h"
#include "appliance/commands/refusal.h"
#include "appliance/commands/stop_signal.h"
#include "appliance/parts/model_reader.h"
#include "appliance/parts/part_model.h"
#include "appliance/parts/sample_bumper.h"
#include "appliance/sessions/depth_png.h"
#include "appliance/sessions/session_writer.h"
#include "appliance/simulation/virtual_cell.h"

namespace deixis {
namespace {

namespace fs = std::filesystem;

struct SimulateOptions {
    std::string scenario, out, part;
    uint64_t seed = 0;
    bool seed_given = false, frames_folder = false, quiet = false;
};

nlohmann::ordered_json list_of(const Eigen::Vector3d& v) {
    const auto rounded = [](double x) { return std::round(x * 1e6) / 1e6; };
    return {rounded(v.x()), rounded(v.y()), rounded(v.z())};
}

/// The line of truth.jsonl for one stamp.
std::string truth_line(const CellTruth& truth, int64_t timestamp_us) {
    nlohmann::ordered_json line;
    line["timestamp_us"] = timestamp_us;
    line["joints"] = nullptr;
    if (truth.joints) {
        nlohmann::ordered_json joints;
        for (size_t i = 0; i < simulated_joint_names.size(); ++i)
            joints[simulated_joint_names[i]] = list_of((*truth.joints)[i]);
        line["joints"] = joints;
    }
    line["part"] = nullptr;
    if (truth.world_from_part) {
        nlohmann::ordered_json rotation = nlohmann::ordered_json::array();
        for (int r = 0; r < 3; ++r) {
            const auto row = truth.world_from_part->rotation.row(r);
            rotation.push_back({row[0], row[1], row[2]});
        }
        line["part"] = {{"rotation", rotation}, {"translation", list_of(truth.world_from_part->translation)}};
    }
    line["pointing"] = nullptr;
    if (truth.pointing) {
        const TruePointing& p = *truth.pointing;
        line["pointing"] = {{"hold", p.hold},
                            {"arm", p.left_arm ? "left" : "right"},
                            {"meant", p.meant},
                            {"touch", p.touch},
                            {"target_part", nullptr}};
        if (p.target_part) line["pointing"]["target_part"] = list_of(*p.target_part);
    }
    return line.dump();
}

std::string quoted(const std::string& text) {
    return nlohmann::json(text).dump();
}

std::string part_toml(const ScenarioPart& part, const std::string& model) {
    std::ostringstream out;
    out.precision(9);
    out << "type = " << quoted(part.type) << "\nserial = " << quoted(part.serial)
        << "\nmodel = " << quoted(model) << "\nunits = " << quoted(part.units) << "\n";
    const auto list = [&](const Eigen::Vector3d& v) {
        out << "[" << v.x() << ", " << v.y() << ", " << v.z() << "]\n";
    };
    for (const auto& zone : part.zones) {
        out << "\n[[zones]]\nname = " << quoted(zone.name) << "\nmin = ";
        list(zone.box.min);
        out << "max = ";
        list(zone.box.max);
    }
    return out.str();
}

std::string expected_toml(const Scenario& scenario) {
    std::ostringstream out;
    for (const auto& [key, value] : scenario.expected) out << key << " = " << value << "\n";
    return out.str();
}

Result<void> write_text(const fs::path& path, const std::string& text) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) return fail(path.string() + ": cannot be written");
    return {};
}

/// Where the frames go: a session or a frames folder. `frame` may be called from one thread a sensor.
class FrameSink {
  public:
    virtual ~FrameSink() = default;
    virtual Result<void> frame(size_t sensor, int64_t number, const DepthFrame& frame) = 0;
    virtual Result<void> background(size_t sensor, const DepthImage& image) = 0;
    virtual Result<void> truth(const std::string& line) = 0;
    virtual Result<void> part(const fs::path& part_toml, const fs::path& model) = 0;
    virtual Result<void> expected(const std::string& toml) = 0;
    virtual Result<void> finish() = 0;
    /// Where all lies until `finish`.
    virtual fs::path unfinished() const = 0;
};

class SessionSink : public FrameSink {
  public:
    explicit SessionSink(SessionWriter writer) : writer_(std::move(writer)) {}
    Result<void> frame(size_t sensor, int64_t, const DepthFrame& f) override {
        const std::scoped_lock lock(mutex_);
        return writer_.append(sensor, f.timestamp_us, f.depth, f.host_us);
    }
    Result<void> background(size_t sensor, const DepthImage& image) override {
        return writer_.set_background(sensor, image);
    }
    Result<void> truth(const std::string& line) override { return writer_.add_truth_line(line); }
    Result<void> part(const fs::path& part_toml, const fs::path&) override {
        return writer_.copy_part(part_toml);
    }
    Result<void> expected(const std::string& toml) override { return writer_.set_expected(toml); }
    Result<void> finish() override { return writer_.finish(); }
    fs::path unfinished() const override { return writer_.working_folder(); }

  private:
    SessionWriter writer_;
    std::mutex mutex_;
};

class FolderSink : public FrameSink {
  public:
    static Result<std::unique_ptr<FrameSink>> create(const fs::path& folder, const SensorRig& rig) {
        std::error_code problem;
        if (fs::exists(folder, problem)) return fail(folder.string() + ": exists already");
        auto sink = std::make_unique<FolderSink>();
        sink->folder_ = folder;
        fs::create_directories(folder / "background", problem);
        for (const CalibratedSensor& sensor : rig.sensors) {
            fs::create_directories(folder / sensor.name, problem);
            sink->names_.push_back(sensor.name);
            sink->stamps_.emplace_back(folder / sensor.name / "timestamps.csv");
            sink->stamps_.back() << "frame,timestamp_us,host_us\n";
        }
        if (problem) return fail(folder.string() + ": cannot be created: " + problem.message());
        if (auto done = write_calibration(rig, folder / "calibration.toml"); !done)
            return tl::unexpected(done.error());
        sink->truth_.open(folder / "truth.jsonl");
        return sink;
    }
    Result<void> frame(size_t sensor, int64_t number, const DepthFrame& f) override {
        std::string name = std::to_string(number);
        name.insert(0, name.size() < 6 ? 6 - name.size() : 0, '0');
        stamps_[sensor] << number << "," << f.timestamp_us << "," << f.host_us << "\n";
        return write_depth_png(f.depth, folder_ / names_[sensor] / (name + ".png"));
    }
    Result<void> background(size_t sensor, const DepthImage& image) override {
        return write_depth_png(image, folder_ / "background" / (names_[sensor] + ".png"));
    }
    Result<void> truth(const std::string& line) override {
        truth_ << line << "\n";
        return {};
    }
    Result<void> part(const fs::path& part_toml, const fs::path& model) override {
        std::error_code problem;
        fs::copy_file(part_toml, folder_ / "part.toml", problem);
        if (!problem) fs::copy_file(model, folder_ / model.filename(), problem);
        if (problem) return fail(folder_.string() + ": the part cannot be copied: " + problem.message());
        return {};
    }
    Result<void> expected(const std::string& toml) override {
        return write_text(folder_ / "expected.toml", toml);
    }
    Result<void> finish() override {
        for (std::ofstream& stamps : stamps_) stamps.close();
        truth_.close();
        for (const std::ofstream& stamps : stamps_)
            if (!stamps) return fail(folder_.string() + ": timestamps.csv cannot be written");
        if (!truth_) return fail((folder_ / "truth.jsonl").string() + ": cannot be written");
        return {};
    }
    fs::path unfinished() const override { return folder_; }

  private:
    fs::path folder_;
    std::vector<std::string> names_;
    std::vector<std::ofstream> stamps_;
    std::ofstream truth_;
};

/// A folder for the part's files until the sink has copied them.
class PassingFolder {
  public:
    PassingFolder() {
        std::string name = (fs::temp_directory_path() / "deixis-simulate-XXXXXX").string();
        if (::mkdtemp(name.data()) != nullptr) path_ = name;
    }
    ~PassingFolder() {
        std::error_code ignored;
        if (!path_.empty()) fs::remove_all(path_, ignored);
    }
    PassingFolder(const PassingFolder&) = delete;
    PassingFolder& operator=(const PassingFolder&) = delete;
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

/// The part's CAD file in `folder`, its part.toml beside it.
Result<fs::path> prepare_part(const ScenarioPart& part, const fs::path& folder) {
    if (folder.empty())
        return fail(fs::temp_directory_path().string() + ": no temporary folder can be made there");
    fs::path model;
    if (part.sample.empty()) {
        model = folder / part.model.filename();
        std::error_code problem;
        fs::copy_file(part.model, model, problem);
        if (problem) return fail(part.model.string() + ": cannot be read: " + problem.message());
    } else {
        model = folder / ("bumper-" + part.sample + ".step");
        const auto variant = part.sample == "a" ? SampleBumper::a : SampleBumper::b;
        if (auto done = write_sample_bumper(variant, model); !done) return tl::unexpected(done.error());
    }
    if (auto done = write_text(folder / "part.toml", part_toml(part, model.filename().string())); !done)
        return tl::unexpected(done.error());
    return model;
}

/// Renders every frame, one thread a sensor; prints progress to stderr.
Result<void> render_all(VirtualCell& cell, FrameSink& sink, bool quiet) {
    const size_t sensors = cell.rig().sensors.size();
    std::vector<Result<void>> outcome(sensors);
    std::atomic<int64_t> done{0};
    std::atomic<bool> stop{false};
    int64_t total = 0;
    for (size_t s = 0; s < sensors; ++s) total += cell.frame_count(s);
    std::mutex printing;
    {
        std::vector<std::jthread> threads;
        threads.reserve(sensors);
        for (size_t s = 0; s < sensors; ++s)
            threads.emplace_back([&, s] {
                DepthFrame frame;
                for (int64_t i = 0; i < cell.frame_count(s) && !stop && !stop_requested(); ++i) {
                    cell.render(s, i, frame);
                    if (outcome[s] = sink.frame(s, i, frame); !outcome[s]) stop = true;
                    const int64_t now = ++done;
                    if (quiet || now * 20 / total == (now - 1) * 20 / total) continue;
                    const std::scoped_lock lock(printing);
                    std::cerr << "simulate: " << now * 100 / total << " % of " << total << " images\n";
                }
            });
    }
    for (auto& one : outcome)
        if (!one) return one;
    if (stop_requested()) return fail("stopped by a signal; nothing is kept");
    return {};
}

/// All that a session of `cell` consists of, frames last.
Result<void> fill(FrameSink& sink, VirtualCell& cell, const Scenario& scenario, const fs::path& part_toml,
                  const fs::path& model, bool quiet) {
    for (size_t s = 0; s < cell.rig().sensors.size(); ++s)
        if (auto done = sink.background(s, cell.background(s)); !done) return done;
    if (scenario.part.present)
        if (auto done = sink.part(part_toml, model); !done) return done;
    if (!scenario.expected.empty())
        if (auto done = sink.expected(expected_toml(scenario)); !done) return done;
    for (int64_t i = 0; i < cell.frame_count(0); ++i) {
        const FrameTiming when = cell.timing(0, i);
        if (auto done = sink.truth(truth_line(cell.truth(when.time_s), when.timestamp_us)); !done)
            return done;
    }
    if (auto done = render_all(cell, sink, quiet); !done) return done;
    return sink.finish();
}

Result<void> simulate(const SimulateOptions& options) {
    auto scenario = read_scenario(options.scenario);
    if (!scenario) return tl::unexpected(scenario.error());
    for (const std::string& warning : scenario->warnings) std::cerr << "warning: " << warning << "\n";
    if (!options.part.empty()) {
        scenario->part.model = options.part;
        scenario->part.sample.clear();
    }
    const PassingFolder passing;
    SurfaceMesh mesh;
    fs::path model;
    if (scenario->part.present) {
        auto prepared = prepare_part(scenario->part, passing.path());
        if (!prepared) return tl::unexpected(prepared.error());
        model = *prepared;
        auto loaded = load_mesh(model, scenario->part.units == "m" ? 1.0 : 0.001, {program_path()});
        if (!loaded) return tl::unexpected(loaded.error());
        mesh = std::move(*loaded);
    }
    const uint64_t seed = options.seed_given ? options.seed : scenario->seed;
    auto cell = VirtualCell::create(*scenario, seed, mesh);
    if (!cell) return tl::unexpected(cell.error());
    if (!options.quiet) std::cerr << "simulate: seed " << seed << ", " << cell->description() << "\n";

    std::unique_ptr<FrameSink> sink;
    if (options.frames_folder) {
        auto folder = FolderSink::create(options.out, cell->rig());
        if (!folder) return tl::unexpected(folder.error());
        sink = std::move(*folder);
    } else {
        // The same seed makes the same bytes, so the stamp of creation is not the wall clock's.
        auto writer = SessionWriter::create(
            options.out, cell->rig(), {scenario->name, "2024-01-01T00:00:00Z", {{"deixis", DEIXIS_VERSION}}});
        if (!writer) return tl::unexpected(writer.error());
        sink = std::make_unique<SessionSink>(std::move(*writer));
    }
    const fs::path unfinished = sink->unfinished();
    auto filled = fill(*sink, *cell, *scenario, passing.path() / "part.toml", model, options.quiet);
    if (filled) return filled;
    // Half a simulation is worth nothing and would stand in the next one's way.
    sink.reset();
    std::error_code ignored;
    fs::remove_all(unfinished, ignored);
    return filled;
}

}  // namespace

void add_simulate_command(CLI::App& app) {
    auto options = std::make_shared<SimulateOptions>();
    CLI::App* command = app.add_subcommand("simulate", "Render a scenario as a session with known truth");
    command->add_option("scenario", options->scenario, "SCENARIO.toml")->required();
    command->add_option("out", options->out, "session folder to make; must not exist")->required();
    CLI::Option* seed = command->add_option(
        "--seed", options->seed, "draws all that the scenario leaves open; its own \"seed\" without this");
    command->add_option("--part", options->part, "another CAD file in place of the scenario's (same units)");
    command->add_flag("--frames-folder", options->frames_folder,
                      "write PNG images and CSV stamps, input of `deixis import`");
    command->add_flag("--quiet", options->quiet, "no progress");
    command->callback([options, seed] {
        options->seed_given = seed->count() > 0;
        catch_stop_signals();
        if (const auto done = simulate(*options); !done) refuse(done.error());
    });
}

}  // namespace deixis
