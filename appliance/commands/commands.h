// The subcommands of `deixis`, one file each; main.cpp only dispatches.
#pragma once

#include <CLI/CLI.hpp>

namespace deixis {

/// Each adds its subcommand; its callback returns by `throw CLI::RuntimeError(code)` on failure.
/// Exit codes: 0 done, 1 refused or failed (one sentence on stderr), 2 bad arguments.

}  // namespace deixis
