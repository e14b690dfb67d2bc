// `deixis`: dispatches to the subcommands.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "appliance/commands/commands.h"

int main(int argc, char** argv) {
    CLI::App app{"Deixis: a worker points at a part, the station records the defect"};
    app.require_subcommand(1);
    app.set_version_flag("--version", DEIXIS_VERSION);
    deixis::add_station_command(app);
    deixis::add_replay_command(app);
    deixis::add_record_command(app);
    deixis::add_sensor_command(app);
    deixis::add_simulate_command(app);
    deixis::add_import_command(app);
    deixis::add_mend_command(app);
    deixis::add_model_reader_command(app);
    deixis::add_part_command(app);
    deixis::add_doctor_command(app);
    deixis::add_export_command(app);
    deixis::add_plc_command(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::RuntimeError& error) {
        return error.get_exit_code();
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const std::exception& error) {
        std::cerr << "deixis: " << error.what() << '\n';
        return 1;
    }
    return 0;
}
