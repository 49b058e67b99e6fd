#pragma once
#include "optimize/run_records.hpp"

#include <string>

/// What `run` and `fit` share: from the case file to the run folder, progress on stderr, and the report at the end.
namespace strake::cli {

struct SessionArguments {
    std::string case_file, out;
    bool json = false, quiet = false;
};

/// @param is_fit `fit` instead of `run`. @throws ExitStatus unless the run is done, and what the libraries throw.
void run_session(const SessionArguments& args, bool is_fit);

}  // namespace strake::cli
