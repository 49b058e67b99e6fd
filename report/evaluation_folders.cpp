#include "report/evaluation_folders.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cstdio>

namespace strake {

namespace fs = std::filesystem;

EvaluationFolders::EvaluationFolders(const fs::path& run, KeepPolicy keep, bool may_ask_again)
    : folder_(run / "evaluations"), keep_(keep), may_ask_again_(may_ask_again) {}

void EvaluationFolders::add(const EvaluationRecord& record) {
    if (keep_ == KeepPolicy::all) return;
    last_ = record.evaluation;
    last_failed_ = record.status != "ok";
    if (last_failed_) failed_.insert(last_);
    waiting_.insert(last_);
    // Inherited values belong to an earlier evaluation, whose folder stays the one that may be needed again.
    if (record.accepted && !record.is_taken_over) best_ = last_;
    if (record.level_best && !record.is_taken_over) level_best_ = last_;
    sweep({last_, best_, level_best_});
}

void EvaluationFolders::finish(const RunResult& result) {
    if (keep_ == KeepPolicy::all) return;
    std::set<int> wanted;
    if (may_ask_again_) wanted = {last_, best_, level_best_};
    if (result.status == "evaluation_failed" || result.status == "failed") wanted.insert(last_);
    sweep(wanted);
}

bool EvaluationFolders::is_kept(int evaluation) const {
    if (keep_ == KeepPolicy::best && evaluation == best_) return true;
    return keep_ != KeepPolicy::none && failed_.count(evaluation) > 0;
}

void EvaluationFolders::sweep(const std::set<int>& still_wanted) {
    for (auto at = waiting_.begin(); at != waiting_.end();) {
        const int evaluation = *at;
        if (still_wanted.count(evaluation) > 0 || (keep_ == KeepPolicy::best && evaluation == best_)) {
            ++at;
            continue;
        }
        if (!is_kept(evaluation)) remove(evaluation);
        at = waiting_.erase(at);
    }
}

/// 000012, and further attempts 000012-2, …
void EvaluationFolders::remove(int evaluation) {
    char number[16];
    std::snprintf(number, sizeof number, "%06d", evaluation);
    std::error_code why;
    std::vector<fs::path> found;
    for (fs::directory_iterator at(folder_, why), end; !why && at != end; at.increment(why)) {
        const std::string name = at->path().filename().string();
        if (name == number || name.starts_with(std::string(number) + "-")) found.push_back(at->path());
    }
    for (const fs::path& attempt : found) {
        why.clear();
        fs::remove_all(attempt, why);  // removes a link itself, never its target
        const std::string words = text(attempt.string(), ": cannot remove: ", why.message());
        if (why && problems_.size() < 5) problems_.push_back(words);
    }
}

}  // namespace strake
