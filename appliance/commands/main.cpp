// `deixis`: dispatches to the subcommands.
#include <CLI/CLI.hpp>

#include "appliance/commands/commands.h"

int main(int argc, char** argv) {
    CLI::App app{"Deixis: a worker points at a part, the station records the defect"};
    app.require_subcommand(1);
    app.set_version_flag("--version", DEIXIS_VERSION);
    CLI11_PARSE(app, argc, argv);
    return 0;
}
