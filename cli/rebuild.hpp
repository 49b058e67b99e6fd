#pragma once
#include "optimize/journal/journal.hpp"
#include "report/run_folder.hpp"

/// Run folders whose journal is missing, empty or damaged.
namespace strake::cli {

/// What case.yaml says about how the run was started.
struct Beginning {
    bool is_fit = false;
    std::filesystem::path case_dir;
};

/// The run in this folder ended before its first evaluation: nothing is lost by starting it again.
bool has_evaluated_nothing(const std::filesystem::path& dir);
bool says_how_it_began(const std::filesystem::path& dir);
/// @throws InvalidInput with the remedy where case.yaml does not say it.
Beginning beginning_of(const std::filesystem::path& dir);
/// Removes what such a run left of its journal. @pre has_evaluated_nothing(dir)
void clear_journal(const std::filesystem::path& dir);

/// What a damaged journal's message adds: what else the folder holds, and the command that saves it.
std::string rebuild_words(const std::filesystem::path& dir);
/// A journal that holds fewer evaluations than history.csv has lost some: not continued unasked.
/// @throws InputError with the remedy.
void check_against_history(const Journal& journal, const std::filesystem::path& dir);
/// Makes a new journal from what can be read of the old one, which is kept as journal.damaged.sqlite, and says on
/// standard error what was saved and what is lost.
std::unique_ptr<Journal> rebuilt_journal(const std::filesystem::path& dir);

}  // namespace strake::cli
