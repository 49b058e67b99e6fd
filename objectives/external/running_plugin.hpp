#pragma once

namespace strake {

/// Name, file and evaluation of the plug-in whose code is being run, null when none is: a handler of exit() learns from
/// it who has ended the program.
const char* running_plugin();

}  // namespace strake
