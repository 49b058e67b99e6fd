#pragma once
#include "cli/session.hpp"

namespace strake::cli {

/// `run --studio`: the run as a process of its own, and a page that shows it, until the user ends both.
/// @throws ExitStatus unless the run is done.
void run_in_studio(const SessionArguments& args);

}  // namespace strake::cli
