#pragma once
#include "cli/session.hpp"

/// What `resume` and `step` share: whether a run may continue with a case, and under which limits.
namespace strake::cli {

struct Continuation {
    std::string yaml;  ///< the case as resolved now
    bool is_changed = false, has_new_budget = false;
};

/// What keys meant when the run began is what they mean when it goes on. @param meaning `JournalFacts::meaning`
void keep_meaning(Case& the_case, int meaning);
/// That number, as case.yaml of the run folder says; 0: it does not.
int written_meaning(const std::filesystem::path& dir);

/// @throws InvalidInput naming what differs from the case that the run started with.
Continuation continuation(const Case& the_case, const JournalFacts& facts, const std::filesystem::path& dir);

/// Records case and limits in the journal of the request, and sets up its folder to continue from the best design.
/// @throws InvalidInput if a limit is lower than before.
void begin_again(RunRequest& request, const Continuation& now, const RunLimits& limits);

}  // namespace strake::cli
