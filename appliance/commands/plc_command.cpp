// `deixis plc map`: the wiring sheet for whoever programs the PLC.
#include <iostream>

#include "appliance/commands/commands.h"
#include "appliance/plc/register_map.h"

namespace deixis {

void add_plc_command(CLI::App& app) {
    CLI::App* plc = app.add_subcommand("plc", "What the PLC's programmer needs");
    plc->require_subcommand(1);
    static std::string format = "markdown";
    CLI::App* map = plc->add_subcommand("map", "Print the Modbus register map");
    map->add_option("--format", format, "markdown or csv")
        ->check(CLI::IsMember({"markdown", "csv"}))
        ->capture_default_str();
    map->callback([] { std::cout << (format == "csv" ? register_map_csv() : register_map_markdown()); });
}

}  // namespace deixis
