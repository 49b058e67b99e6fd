#pragma once
#include <string>

/// Signals from the user during a run.
namespace strake::cli {

/// From now on the first INT, TERM or HUP is only noted; the second ends the program at once with status 128 + its
/// number. HUP stays ignored where it was (nohup).
/// @param when_ended_at_once a line for stderr at the second one; with it, a terminal is told at the first what another
/// one does.
void watch_signals(const std::string& when_ended_at_once = "");
/// Signals end the program as they did before watch_signals(); a noted signal stays noted.
void leave_signals();

/// INT, TERM and HUP end the program at once with status 75 (nothing has been written; it may simply be run again).
/// @param words for stderr, with static lifetime.
void end_on_signals(const char* words);

bool stop_wanted();
int stop_signal();  ///< its number; 0: none

}  // namespace strake::cli
