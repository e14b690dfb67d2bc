// SIGINT and SIGTERM as a flag that loops ask; a second signal ends the program at once.
#pragma once

namespace deixis {

/// Installs the handlers; call once before the loop.
void catch_stop_signals();

/// True since the first SIGINT or SIGTERM.
bool stop_requested();

}  // namespace deixis
