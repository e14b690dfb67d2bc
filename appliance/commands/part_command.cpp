// `deixis part`: writes a sample bumper, or says what the station makes of a model file.
#include <algorithm>
#include <iostream>

#include "appliance/commands/commands.h"
#include "appliance/commands/program_path.h"
#include "appliance/commands/refusal.h"
#include "appliance/parts/model_reader.h"
#include "appliance/parts/part_model.h"
#include "appliance/parts/sample_bumper.h"
#include "tracking/part/reference_model.h"

namespace deixis {
namespace {

void print_model(const std::filesystem::path& model, double metres_per_unit,
                 const ModelReaderParams& limits) {
    const auto mesh = load_mesh(model, metres_per_unit, {program_path(), limits});
    if (!mesh) refuse(mesh.error());
    const auto reference = ReferenceModel::build(*mesh, {});
    if (!reference) refuse({model.string() + ": " + reference.error().sentence});
    const MeshBounds bounds = bounds_of(*mesh);
    const Eigen::IOFormat row(4, Eigen::DontAlignCols, ", ", ", ", "", "", "[", "]");
    const auto outer = std::count_if((*reference)->fine().begin(), (*reference)->fine().end(),
                                     [](const SkinPoint& p) { return p.outer; });
    std::cout << "model       " << model.string() << '\n'
              << "triangles   " << mesh->triangles.size() << '\n'
              << "bounds [m]  " << bounds.min.transpose().format(row) << " to "
              << bounds.max.transpose().format(row) << '\n'
              << "reference   " << outer << " outer and " << (*reference)->fine().size() - outer
              << " inner points, " << (*reference)->coarse().size() << " with descriptors\n";
}

void print_info(const std::filesystem::path& file, const std::string& units,
                const ModelReaderParams& limits) {
    if (file.extension() != ".toml") return print_model(file, units == "m" ? 1 : 1e-3, limits);
    const auto part = read_part_file(file);
    if (!part) refuse(part.error());
    for (const std::string& warning : part->warnings) std::cerr << warning << '\n';
    std::cout << "type        " << part->type << "\nserial      " << part->serial << '\n';
    print_model(part->model, part->metres_per_unit, limits);
    for (const Zone& zone : part->zones) std::cout << "zone        " << zone.name << '\n';
}

}  // namespace

void add_part_command(CLI::App& app) {
    CLI::App* part = app.add_subcommand("part", "Sample bumpers, and what the station makes of a model file");
    part->require_subcommand(1);

    static struct {
        std::string output, variant = "a", file, units = "mm";
        ModelReaderParams limits;
    } options;
    CLI::App* sample = part->add_subcommand("sample", "Write a sample bumper as STEP, in millimetres");
    sample->add_option("OUT.step", options.output, "file to write")->required();
    sample->add_option("--variant", options.variant, "a: front bumper, b: rear bumper")
        ->check(CLI::IsMember({"a", "b"}))
        ->capture_default_str();
    sample->callback([] {
        const auto variant = options.variant == "b" ? SampleBumper::b : SampleBumper::a;
        if (const auto written = write_sample_bumper(variant, options.output); !written)
            refuse(written.error());
    });

    CLI::App* info =
        part->add_subcommand("info", "Check a part.toml or a model file and print what is in it");
    info->add_option("FILE", options.file, "part.toml, or a STEP, IGES, STL, OBJ or PLY file")->required();
    info->add_option("--units", options.units, "unit of a model file given directly")
        ->check(CLI::IsMember({"mm", "m"}))
        ->capture_default_str();
    info->add_option("--time-limit", options.limits.time_limit_s, "seconds that reading the model may take")
        ->check(CLI::Range(0.001, 3600.0))
        ->capture_default_str();
    info->callback([] { print_info(options.file, options.units, options.limits); });
}

}  // namespace deixis
