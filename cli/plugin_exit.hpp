#pragma once
#include <string>

/// A plug-in that calls exit() would end a run with status 0 and without a word.
namespace strake::cli {

/// From now on such an end names the plug-in, and has the status of a program that failed.
void watch_for_exit();
/// What it then says about how to go on, for example "`strake resume DIR` continues".
void say_at_exit(const std::string& words);

}  // namespace strake::cli
