#pragma once
#include "casefile/model/case.hpp"
#include "optimize/journal/journal.hpp"
#include "report/run_folder.hpp"

/// What `run`, `fit`, `step` and `resume` share: from the case file to the run folder, progress on stderr, and the
/// report at the end.
namespace strake::cli {

struct SessionArguments {
    std::string case_file, out;
    std::vector<std::string> settings;  ///< KEY=VALUE
    bool json = false, quiet = false;
};

/// @param is_fit `fit` instead of `run`. @throws ExitStatus unless the run is done, and whatever the libraries throw.
void run_session(const SessionArguments& args, bool is_fit);

/// A run or a fit that is ready to start or to continue.
struct RunRequest {
    Case the_case;
    bool is_fit = false, json = false, quiet = false;
    bool is_step = false;               ///< waits for answers from outside instead of running programs
    std::unique_ptr<RunFolder> folder;  ///< null: a new one, at output.dir
    std::unique_ptr<Journal> journal;   ///< of a run that continues; null: a new one
};

/// Builds the problem, searches, and reports the end. @throws as run_session.
void carry_out(RunRequest request);

/// The requested folder, otherwise that of the case.
void set_output_folder(Case& the_case, const std::string& wanted);

}  // namespace strake::cli
