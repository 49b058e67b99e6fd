#pragma once
#include "optimize/run/run_records.hpp"

#include <filesystem>
#include <set>

/// The folders in which programs run, for example evaluations/000012, during a run and after it.
namespace strake {

enum class KeepPolicy {
    all,     ///< nothing is removed
    failed,  ///< those of evaluations without a value
    best,    ///< those, and that of the best design
    none
};

/// Removes the folders that are not kept once the journal holds their results: no continued run pays for them again.
/// Folders that may still be needed for a gradient stay: those of the last evaluation, the best one and the best of the
/// level.
class EvaluationFolders {
public:
    /// @param may_ask_again a quantity has a separate program for gradients: these folders also stay after the end,
    /// since a run with a raised budget may start there.
    EvaluationFolders(const std::filesystem::path& run, KeepPolicy keep, bool may_ask_again);

    /// The evaluation is in the journal; earlier folders that are no longer needed are removed.
    void add(const EvaluationRecord& record);
    /// The run is over (not: interrupted, or waiting for answers).
    void finish(const RunResult& result);

    /// Messages about folders that could not be removed, each once.
    const std::vector<std::string>& problems() const { return problems_; }

private:
    bool is_kept(int evaluation) const;
    void sweep(const std::set<int>& still_wanted);
    void remove(int evaluation);

    std::filesystem::path folder_;
    KeepPolicy keep_ = KeepPolicy::all;
    bool may_ask_again_ = false;
    int last_ = 0, best_ = 0, level_best_ = 0;
    bool last_failed_ = false;
    std::set<int> waiting_, failed_;  ///< not removed yet; failed evaluations
    std::vector<std::string> problems_;
};

}  // namespace strake
