#pragma once
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/journal/journal.hpp"
#include "optimize/run/run_records.hpp"
#include "optimize/space/response_cache.hpp"

#include <chrono>

/// What `optimize` and `fit` share while they walk down the levels: counting, records, the best design. Internal.
namespace strake {

/// How an evaluation ranks: feasible ones by objective (as minimized), others by violation.
struct Rank {
    bool feasible = false;
    double violation = std::numeric_limits<double>::infinity(), merit = std::numeric_limits<double>::infinity();
    bool better_than(const Rank& other) const {
        if (feasible != other.feasible) return feasible;
        return feasible ? merit < other.merit : violation < other.violation;
    }
};

class RunState {
public:
    /// @param journal that the run is written to and replayed against; may be null.
    /// @param energy_share, takes_single_patches see `RestFacts`
    RunState(const Problem& problem, const RunEvents& events, const std::vector<std::string>& differentiated,
             Journal* journal = nullptr, double energy_share = 1, bool takes_single_patches = false);
    ~RunState() { rest->cache->stop_wanted = {}; }  // the result keeps the rest, and the run is over
    RunState(const RunState&) = delete;
    RunState& operator=(const RunState&) = delete;

    /// Evaluates x as the next evaluation of the run. @throws ReplayMismatch; Interrupted; Awaited.
    ShapeEvaluation evaluate(const Eigen::VectorXd& x);
    /// Completes the gradients of the last evaluation. @throws Interrupted; Awaited.
    void differentiate(ShapeEvaluation& evaluation);
    /// Ends the run between two evaluations; `result.pending` tells of jobs that stay. @throws Interrupted.
    [[noreturn]] void interrupt();
    /// Vertex sensitivities of the objective came later than the values of the last evaluation.
    void tell_sensitivities(const ShapeEvaluation& evaluation, const Points& dJ_dv) const;
    /// Records the last evaluation. `objective` as the case states it. Returns whether it is the best of the level;
    /// then the next evaluation starts from its equilibrium.
    bool record(const Eigen::VectorXd& x, const ShapeEvaluation& evaluation, double objective, const Rank& rank,
                const Points& dJ_dv);

    /// Makes the space of the next level (from `x` of the present one) and enters it.
    /// @param next what the level is made of; without it the next level of the tree.
    Eigen::VectorXd next_level(const Eigen::VectorXd& x, const LevelSet* next = nullptr);
    /// The variables of the first level again as those of the next one, from the start of the run.
    Eigen::VectorXd first_level_again();
    /// There are finer patches than the present ones.
    bool can_refine() const;
    void end_level(const std::string& why);  ///< completes the level's summary
    void leave_level();                      ///< the run continues another time: the summary up to now
    /// Runs the search. Where it is interrupted, or waits for answers from outside, the result says so.
    void run(const std::function<void()>& search);
    /// What `ask` leaves unfinished goes to the result.
    void with_unfinished_calls(const std::function<void()>& ask);
    Journal* journal() const { return journal_; }
    void begin_level_again();  ///< from its best design, under the limits of now

    int evaluations_of_level() const;  ///< of the present one, up to now
    int evaluations_left() const { return limits().evaluations - result.evaluations; }
    /// In force now: those of the problem, or what the journal says of them.
    RunLimits limits() const;
    /// Seconds of the run, those of earlier starts included. While it is replayed, those of then.
    double elapsed() const;
    /// A level ended at the limits of then, and the run may go on under larger ones.
    bool limits_were_raised() const;
    int last_level() const { return space.level + levels_left(); }
    /// Levels that may still come, at least; 0 when the present one is the last.
    int levels_left() const;
    double seconds_left() const;  ///< of the whole run; infinite without a limit
    /// What relative limits are multiples of: the values where the first of the runs that follow each other began.
    std::vector<double> values_at_rest(const std::vector<double>& first) const;
    void note(const std::string& words) const {
        if (events.note) events.note(words);
    }

    const Problem& problem;
    const RunEvents& events;
    std::shared_ptr<const RestFacts> rest;
    ShapeEvaluator evaluator;
    DesignSpace space;             ///< of the present level
    Eigen::MatrixXd prolongation;  ///< from the level before, variables x variables; empty on the first
    RunResult result;
    Rank level_best, run_best;
    bool start_is_feasible = false;
    Points level_best_vertices;
    int level_best_evaluation = 0;
    Eigen::VectorXd level_best_x;  ///< empty: the level has no evaluation that is ok
    double level_best_objective = std::numeric_limits<double>::quiet_NaN();
    /// Of the next levels: ranges of variables are as wide as the motion limit lets them be together.
    bool begins_with_wide_ranges = false;
    double range_ratio = 1;           ///< of the present level: the most that this has made of a range
    std::optional<int> levels_below;  ///< `levels_left`, where the run orders its levels by itself; else by the tree
    bool is_trying = false;  ///< only the first evaluation of the level counts as its best: the others are differences

private:
    Eigen::VectorXd first_level();
    Eigen::VectorXd enter_level(Eigen::VectorXd start);  ///< the present space
    void check_inheritance(const ShapeEvaluation& evaluation, double objective);
    void check_design(const Eigen::VectorXd& x) const;
    static void check_values(const JournalEvaluation& then, const EvaluationRecord& record);
    void keep(const Eigen::VectorXd& x, const ShapeEvaluation& evaluation, EvaluationRecord& record);
    void complete_summary(const std::string& why);

    Journal* journal_ = nullptr;
    RunLimits level_limits_;  ///< when the level began or was begun again
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();  ///< of what is not replayed
    double elapsed_before_ = 0, last_seconds_ = 0;
    int replayed_ = 0;  ///< evaluations that the journal held at the start
    bool level_has_started_ = false;
    bool follows_tree_ = true;  ///< the front is a level of the tree
    std::vector<std::pair<std::string, double>> at_rest_;
};

/// Has progress slackened? The gain per evaluation over the last few of them, against the best such rate of the
/// level.
class ProgressWatch {
public:
    /// @param more evaluations that a look at progress takes beside the usual ones.
    explicit ProgressWatch(double fraction, int more = 0) : fraction_(fraction), window_(5 + more) {}
    /// What an evaluation gave, where it has values.
    struct Seen {
        double objective, total_violation, largest_violation;
    };
    /// After one more evaluation, by the lowest objective + `penalty` * violations before and after each: with the
    /// present penalty throughout, because differences between merits of different penalties are no progress.
    bool slackened(const std::optional<Seen>& last, double penalty);

private:
    double fraction_;
    int window_;
    bool near_feasible_ = false;
    std::vector<std::optional<Seen>> seen_;  ///< since the constraints are nearly met, if they ever were
};

}  // namespace strake
