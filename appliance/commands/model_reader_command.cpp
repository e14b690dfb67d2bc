// `deixis model-reader`: the process that reads one model file, started by whoever loads a part.
#include <memory>

#include "appliance/commands/commands.h"
#include "appliance/parts/model_reader_child.h"

namespace deixis {

void add_model_reader_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "model-reader", "Hand the triangles of one model file to another `deixis` (which starts this)");
    auto request = std::make_shared<ModelRequest>();
    command->add_option("--model", request->model, "STEP, IGES, STL, OBJ or PLY file")->required();
    command->add_option("--metres-per-unit", request->metres_per_unit, "unit of the file [m]")->required();
    command->add_option("--time-limit", request->limits.time_limit_s, "seconds that it may take");
    command->add_option("--memory-limit", request->limits.memory_limit_mb, "megabytes that it may take");
    command->add_option("--reply", request->reply_file, "open file that takes the reply")->required();
    command->callback([request] { run_model_reader(*request); });
}

}  // namespace deixis
