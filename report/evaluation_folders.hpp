#pragma once
#include "optimize/run_records.hpp"

#include <filesystem>
#include <set>

/// The folders in which programs were run, evaluations/000012 and the like, while a run goes on and after it.
namespace strake {

enum class KeepPolicy {
    all,     ///< nothing is removed
    failed,  ///< those of evaluations that gave no value
    best,    ///< these, and that of the best design
    none
};

/// Removes what is not to be kept, once the journal holds it: no run pays for it again, however it goes on. What may
/// still be asked for a gradient stays: the folder of the last evaluation, of the best one and of the best of the
/// level.
class EvaluationFolders {
public:
    /// @param may_ask_again a quantity has a program of its own for gradients: these folders stay after the end, too,
    /// since a raised budget may begin there.
    EvaluationFolders(const std::filesystem::path& run, KeepPolicy keep, bool may_ask_again);

    /// The evaluation is in the journal. What was asked before it, and is not wanted any more, goes.
    void add(const EvaluationRecord& record);
    /// The run is over (not: interrupted, or waiting for answers).
    void finish(const RunResult& result);

    /// Folders that could not be removed, in words, each once.
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
    std::set<int> waiting_, failed_;  ///< not removed yet; of them or of those that stay
    std::vector<std::string> problems_;
};

}  // namespace strake
