#pragma once
#include "optimize/journal/content_hash.hpp"
#include "optimize/journal/journal_records.hpp"

#include <memory>
#include <mutex>

struct sqlite3;

/// The journal of a run, `journal.sqlite` in its folder: every evaluation, and before that every call of a program, is
/// on the disk before the optimizer sees it. A run that died is replayed from its start against it: the optimizer asks
/// for the same designs again. Shapes are computed anew; calls of programs are answered from here (`QuantityCalls`),
/// and the evaluations are compared bit by bit. One writer; calls may be found and added by several threads.
namespace strake {

class Journal {
public:
    /// Makes a new one. @throws OutputError with path and reason.
    static std::unique_ptr<Journal> create(const std::filesystem::path& file, const JournalFacts& facts,
                                           const RunLimits& limits);
    /// Opens that of a run which is to go on, and checks all of it.
    /// @throws InputError: missing, no journal of Strake, of a newer version, damaged (where); nothing is changed.
    static std::unique_ptr<Journal> open(const std::filesystem::path& file);
    /// For looking only, also while the run is alive: evaluations and limits as they are now.
    static std::unique_ptr<Journal> look(const std::filesystem::path& file);
    ~Journal();

    const JournalFacts& facts() const { return facts_; }
    const std::vector<JournalEvaluation>& evaluations() const { return evaluations_; }
    const RunLimits& limits_after(int evaluations) const;  ///< in force then
    const RunLimits& limits() const { return limits_.back(); }

    /// The evaluation of that number, or null where the run has not come so far.
    const JournalEvaluation* find(int number) const;
    /// What a program gave; nothing where it was not called or did not end.
    std::optional<JournalCall> find_call(int evaluation, const std::string& quantity) const;

    /// Each returns when it is on the disk. @throws OutputError with path and reason.
    void add(const JournalEvaluation& evaluation);
    void add(const JournalCall& call);
    /// Calls for evaluations from this number on, none of which is recorded, are forgotten: others are asked for.
    void drop_calls_from(int evaluation);
    /// Evaluations for which a call was answered by a cache.
    std::vector<int> cached() const;
    std::vector<ProgramCost> program_costs() const;  ///< by name
    /// In force from now on, or from when the last ones were to be.
    void set_limits(int max_evaluations, double max_seconds);
    /// In force once there are so many evaluations, which may be more than there are yet. @pre none come later
    void add(const RunLimits& limits);
    void set_case(const std::string& yaml);

private:
    Journal(const std::filesystem::path& file, int flags);
    void check_version();
    void read_facts();
    void read_evaluations();
    /// Failures that ended the run, and calls that have none: asked again.
    void drop_final_failure();

    std::filesystem::path file_;
    sqlite3* db_ = nullptr;
    mutable std::mutex busy_;
    JournalFacts facts_;
    std::vector<RunLimits> limits_;
    std::vector<JournalEvaluation> evaluations_;
};

}  // namespace strake
