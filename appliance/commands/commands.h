// The subcommands of `deixis`, one file each; main.cpp only dispatches.
#pragma once

#include <CLI/CLI.hpp>

namespace deixis {

/// Each adds its subcommand. A callback that fails writes one sentence to stderr and throws
/// `CLI::RuntimeError(code)`. Exit codes of the program: 0 done, 1 refused or failed, 2 bad arguments.
void add_doctor_command(CLI::App& app);
void add_export_command(CLI::App& app);
void add_import_command(CLI::App& app);
void add_mend_command(CLI::App& app);
void add_model_reader_command(CLI::App& app);
void add_part_command(CLI::App& app);
void add_plc_command(CLI::App& app);
void add_replay_command(CLI::App& app);
void add_record_command(CLI::App& app);
void add_sensor_command(CLI::App& app);
void add_simulate_command(CLI::App& app);
void add_station_command(CLI::App& app);

}  // namespace deixis
