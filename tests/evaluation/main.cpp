// `deixis-evaluate`: dispatches to the evaluation programs.
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>

#include "tests/evaluation/evaluations.h"

namespace deixis {

void write_figures(const nlohmann::ordered_json& figures, const std::string& path) {
    if (path.empty()) return;
    std::ofstream out(path);
    out << figures.dump(2) << '\n';
    if (!out.flush()) refuse_evaluation(path + " cannot be written");
}

void refuse_evaluation(const std::string& sentence) {
    std::cerr << "deixis-evaluate: " << sentence << '\n';
    throw CLI::RuntimeError(1);
}

}  // namespace deixis

int main(int argc, char** argv) {
    CLI::App app{"Deixis' evaluation programs: results against the truth, a table and figures as JSON"};
    app.require_subcommand(1);
    deixis::add_marks_evaluation(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::RuntimeError& failed) {
        return failed.get_exit_code();
    } catch (const CLI::ParseError& wrong) {
        return app.exit(wrong) == 0 ? 0 : 2;
    }
    return 0;
}
