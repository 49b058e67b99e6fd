#pragma once
#include "casefile/build/build_problem.hpp"
#include "optimize/journal/journal.hpp"
#include "optimize/run/run_records.hpp"
#include "report/run_folder.hpp"

#include <functional>
#include <map>
#include <string>

/// The search of a case, recorded in the run folder.
namespace strake {

/// The second line of case.yaml, before a number: what the keys mean to the run (`JournalFacts::meaning`).
inline constexpr const char* meaning_note = "# meaning of its keys: ";

/// Runs (or fits) and writes journal, history and designs. A run that fails before its first evaluation leaves no
/// folder behind, and the corrected case can use the same one; a run that fails later leaves a report.
/// @param also further callbacks. @param journal of a run that continues; null: a new one. @param warn receives a
/// message if the report could not be written.
RunResult recorded_run(const BuiltProblem& built, const Case& the_case, RunFolder& folder, bool is_fit,
                       const RunEvents& also, std::unique_ptr<Journal> journal = nullptr,
                       const std::function<void(const std::string&)>& warn = {});

/// report.html is to be made: the case asks for it, or does not say and this program has the page.
bool wants_report(const Case::Output& output);

/// Writes report.html beside the other records. @return empty, or why it could not be written; nothing else is
/// affected.
std::string make_report(const BuiltProblem& built, const Case& the_case, const std::filesystem::path& folder);

/// Names of all values of the problem's quantities.
std::vector<std::string> value_names(const Problem& problem);

/// Hashes of the files named by the case, by key. @throws InputError if one cannot be read.
std::map<std::string, std::string> file_hashes(const Case& the_case);

}  // namespace strake
