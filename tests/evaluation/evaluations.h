// The evaluation programs of `deixis-evaluate`, one file each; main.cpp only dispatches.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

namespace deixis {

/// Each adds its subcommand, prints a table and with `--json FILE` writes its figures as one object. Its
/// callback throws CLI::RuntimeError: 1 after one sentence on stderr, or when what was demanded is not met.
void add_marks_evaluation(CLI::App& app);

/// Writes `figures` to `path` unless that is empty; throws CLI::RuntimeError when it cannot.
void write_figures(const nlohmann::ordered_json& figures, const std::string& path);

/// One sentence on stderr, then CLI::RuntimeError(1).
[[noreturn]] void refuse_evaluation(const std::string& sentence);

}  // namespace deixis
