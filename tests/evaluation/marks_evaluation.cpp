// `deixis-evaluate marks`: the marks and part poses of a results file against the truth of its session.
#include <filesystem>
#include <iostream>
#include <memory>

#include "appliance/acceptance/acceptance_report.h"
#include "appliance/parts/model_file.h"
#include "appliance/parts/part_model.h"
#include "tests/evaluation/evaluations.h"

namespace deixis {

namespace {

struct MarksOptions {
    std::string session, truth, results, expected, json;
    double tolerance_mm = 100;
    bool every_mark = false;
};

template <class T>
T value_or_refuse(Result<T> result) {
    if (!result) refuse_evaluation(result.error().sentence);
    return std::move(*result);
}

void print_warnings(const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) std::cerr << "warning: " << warning << '\n';
}

std::optional<Box> part_box_of(const std::filesystem::path& session) {
    const std::filesystem::path file = session / "part.toml";
    if (session.empty() || !std::filesystem::exists(file)) return std::nullopt;
    const PartFile part = value_or_refuse(read_part_file(file));
    const SurfaceMesh mesh = value_or_refuse(read_model_file(part.model, part.metres_per_unit));
    const MeshBounds bounds = bounds_of(mesh);
    return Box{bounds.min.cast<double>(), bounds.max.cast<double>()};
}

void evaluate_marks(const MarksOptions& options) {
    const std::filesystem::path session = options.session;
    if (session.empty() && options.truth.empty()) refuse_evaluation("give a SESSION or --truth FILE");
    std::filesystem::path truth_path = options.truth;
    if (truth_path.empty()) truth_path = session / "truth.jsonl";
    const Truth truth = value_or_refuse(read_truth(truth_path));
    const Results results = value_or_refuse(read_results(std::filesystem::path(options.results)));
    print_warnings(truth.warnings);
    print_warnings(results.warnings);

    Demands demands;
    std::filesystem::path expected_path = options.expected;
    if (expected_path.empty() && !session.empty() && std::filesystem::exists(session / "expected.toml")) {
        expected_path = session / "expected.toml";
    }
    if (!expected_path.empty()) {
        demands.expected = value_or_refuse(read_expected(expected_path));
        print_warnings(demands.expected->warnings);
    }
    demands.every_mark = options.every_mark || !demands.expected;

    MarkMatchingParams params;
    params.tolerance_m = options.tolerance_mm * 1e-3;
    for (const InvalidSetting& wrong : params.validate()) {
        refuse_evaluation(wrong.key + " is " + wrong.value + ", expected " + wrong.range);
    }
    const AcceptanceReport report = judge_session(truth, results, demands, part_box_of(session), params);
    std::cout << table_of(report);
    write_figures(to_json(report), options.json);
    if (!report.failures.empty()) throw CLI::RuntimeError(1);
}

}  // namespace

void add_marks_evaluation(CLI::App& app) {
    auto options = std::make_shared<MarksOptions>();
    CLI::App* marks = app.add_subcommand("marks", "marks and part poses of a results file against the truth");
    marks->add_option("session", options->session, "session or frames folder with truth.jsonl");
    marks->add_option("--truth", options->truth, "truth file instead of the session's");
    marks->add_option("--results", options->results, "results.jsonl of a replay")->required();
    marks->add_option("--expected", options->expected, "criteria instead of the session's expected.toml");
    marks->add_option("--tolerance-mm", options->tolerance_mm,
                      "farthest from its true spot that a mark is right");
    marks->add_flag("--every-mark", options->every_mark,
                    "demand one mark in its place a meant gesture and no false one, beside expected.toml");
    marks->add_option("--json", options->json, "write the figures to this file");
    marks->callback([options] { evaluate_marks(*options); });
}

}  // namespace deixis
