#pragma once
#include "core/error.hpp"
#include "objectives/quantity.hpp"

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>

struct sqlite3;

/// The journal of a run, `journal.sqlite` in its folder: every evaluation, and before that every call of a program, is
/// on the disk before the optimizer sees it. A run that died is replayed from its start against it: the optimizer asks
/// for the same designs again, and what is in the journal is not paid again. One writer; calls may be found and added
/// by several threads.
namespace strake {

/// A run asks for something else than what its journal says that it did; the text says where, and why that may be.
struct ReplayMismatch : InvalidInput {
    using InvalidInput::InvalidInput;
};

/// The limits of a run, in force once `after` evaluations have been made.
struct RunLimits {
    int after = 0, evaluations = 0;
    double seconds = 0;  ///< 0: no limit
};

struct JournalFacts {
    std::string case_yaml;           ///< as in case.yaml of the folder
    std::filesystem::path case_dir;  ///< of the file that the run was started with, absolute
    std::string host;                ///< machine on which the run began
    bool is_fit = false;
    std::vector<std::string> values, own;      ///< names of the values and of the own variables
    std::map<std::string, std::string> files;  ///< hash of each file that the case names
};

struct JournalEvaluation {
    int number = 0;  ///< from 1, without gaps
    int level = 0;
    std::string status, reason;  ///< as in EvaluationRecord
    Eigen::VectorXd x;           ///< the whole design, exact
    std::vector<double> values, own;
    double objective = 0, max_violation = 0;  ///< NaN: none
    double max_displacement = 0;
    bool accepted = false, is_taken_over = false;
    /// A failure that ends the run is no answer: the next start asks again.
    bool is_final_failure = false;
    std::string surface;  ///< hash of the deformed surface; empty: none
    double seconds = 0;   ///< of this evaluation
    double elapsed = 0;   ///< of the run up to its end, in all starts together
};

/// What a program gave in an evaluation.
struct JournalCall {
    int evaluation = 0;
    std::string quantity;          ///< the name of its first value
    std::string program, surface;  ///< hashes of what was run and of what it was given
    QuantityResult result;
    double seconds = 0;
};

/// What calls of a program cost, all together.
struct ProgramCost {
    std::string quantity;  ///< as in JournalCall
    int calls = 0, failed = 0, cached = 0;
    double seconds = 0;
};

class Journal {
public:
    /// Makes a new one. @throws OutputError with path and reason.
    static std::unique_ptr<Journal> create(const std::filesystem::path& file, const JournalFacts& facts,
                                           const RunLimits& limits);
    /// Opens that of a run which is to go on, and checks all of it.
    /// @throws InputError: missing, no journal of Strake, of a newer version, damaged (where); nothing is changed.
    static std::unique_ptr<Journal> open(const std::filesystem::path& file);
    /// For looking only, also while the run goes on: evaluations and limits as they are now.
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
    /// From now on; the run goes on under them.
    void set_limits(int max_evaluations, double max_seconds);
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

/// FNV-1a, 64 bits, in hexadecimal digits.
std::string content_hash(std::string_view bytes);
/// Of vertices and triangles.
std::string content_hash(const TriMesh& surface);

}  // namespace strake
