// How a subcommand ends that could not do what it was asked: its one sentence, and the program's exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <iostream>

#include "tracking/geometry/result.h"

namespace deixis {

/// Writes the sentence to standard error, after `prefix`, and leaves the callback: the program exits with 1.
[[noreturn]] inline void refuse(const Failure& failure, const char* prefix = "") {
    std::cerr << prefix << failure.sentence << '\n';
    throw CLI::RuntimeError(1);
}

}  // namespace deixis
