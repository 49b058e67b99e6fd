#pragma once
#include "cases/build_problem.hpp"
#include "optimize/journal.hpp"
#include "optimize/run_records.hpp"
#include "report/run_folder.hpp"

#include <functional>
#include <map>
#include <string>

/// The search of a case whose records go to the folder of the run.
namespace strake {

/// Runs (or fits) and writes journal, history and designs. A run that fails before its first evaluation leaves no
/// folder behind, so that the corrected one can go there; one that fails later leaves a report.
/// @param also who else is told what happens, and asked to stop. @param journal of a run that goes on; null: a new one
/// is made. @param warn is told what could not be written of the report.
RunResult recorded_run(const BuiltProblem& built, const Case& the_case, RunFolder& folder, bool is_fit,
                       const RunEvents& also, std::unique_ptr<Journal> journal = nullptr,
                       const std::function<void(const std::string&)>& warn = {});

/// report.html beside the other records. Empty, or what keeps it from being made, which changes nothing else.
std::string make_report(const BuiltProblem& built, const Case& the_case, const std::filesystem::path& folder);

/// Names of all values of the problem's quantities.
std::vector<std::string> value_names(const Problem& problem);

/// Of the files that the case names, by key. @throws InputError where one cannot be read.
std::map<std::string, std::string> file_hashes(const Case& the_case);

}  // namespace strake
