#pragma once
#include "optimize/space/design_space.hpp"

/// Progress of a run or a fit, and its result.
namespace strake {

struct DesignTable;

struct EvaluationRecord {
    int evaluation = 0;  ///< from 1, over the whole run
    int level = 0;
    std::string status;  ///< "ok", or why there is no value, in one word
    std::string reason;  ///< the same in words; empty when ok
    double objective =
        std::numeric_limits<double>::quiet_NaN();  ///< as the case states it (a fit: mean square distance)
    std::vector<double> values;      ///< of all quantities, in the order of `RunResult::names`; empty when not ok
    std::vector<double> parameters;  ///< values of the parameters, in their order
    double max_violation = std::numeric_limits<double>::quiet_NaN();  ///< largest scaled constraint violation
    bool accepted = false;                                            ///< the best design so far
    bool level_best = false;                                          ///< the best one of its level so far
    double max_displacement = 0;                                      ///< of the surface from its start, length
    double seconds = 0;          ///< wall clock of this evaluation; not part of the history
    bool is_taken_over = false;  ///< values of the same shape on the level before: nothing was called
    bool is_replayed = false;    ///< it is in the journal already: no program was called
};

/// A best-so-far design; views are valid during the call.
struct AcceptedDesign {
    const EvaluationRecord& record;
    const DesignSpace& space;
    const Eigen::VectorXd& x;
    const Points& vertices;
    const Points& dJ_dv;  ///< of the objective, n x 3; empty when not at hand
    const Poses& poses;
    const std::vector<std::pair<std::string, double>>& at_rest;  ///< what relative limits are multiples of
};

struct LevelStart {
    const DesignSpace& space;
    const Eigen::VectorXd& x;
};

struct LevelSummary {
    int level = 0, patches = 0, variables = 0, evaluations = 0;
    std::string stop;  ///< why the level ended, one sentence
    double objective_start = 0, objective_end = 0;
    double inherited_shape_change = 0;      ///< largest vertex motion by the refinement, in diagonals
    double inherited_objective_change = 0;  ///< relative
    /// Of a fit: the share of the root mean square distance left by the levels before that this level removed.
    double explained = std::numeric_limits<double>::quiet_NaN();
    bool converged = false;                 ///< of a fit: `objective_end` is the least that this level can reach
    std::vector<std::string> dependent;     ///< variables whose directions, beside those of the others, move nothing
    std::vector<std::string> weak;          ///< variables that do nearly what others can do
    std::vector<std::string> nearly_fixed;  ///< patches with almost no free area
};

struct RunEvents {
    std::function<void(const LevelStart&)> level;
    std::function<void(const EvaluationRecord&)> evaluation;
    std::function<void(const AcceptedDesign&)> accepted;
    /// dJ/dv of the objective (n x 3) came after the design, which was the last to be accepted.
    std::function<void(int evaluation, const Points& vertices, const Points& dJ_dv)> sensitivities;
    std::function<void(const LevelSummary&)> level_end;
    std::function<void(const std::string&)> note;
    /// Asked before every evaluation and while a program runs; true ends the run (status `interrupted`). From the
    /// thread of the run.
    std::function<bool()> stop_wanted;
};

/// What the motion limit has to do with where a run ended.
struct MotionAtEnd {
    bool is_limited = false;  ///< the run has a motion limit
    bool is_active = false;   ///< some vertex of the best design is at its limit
    double used = 0;          ///< largest share of its limit that a vertex of the best design uses
    int vertex = -1;          ///< that one
    int num_vertices = 0;     ///< at their limits
    double limit = 0;         ///< of the vertex, in diagonals
    std::string where;        ///< patch of the vertex
    /// Change of the objective, as the case states it, by 0.1 % of the diagonal more motion everywhere; to first order,
    /// from the multipliers. NaN: not known.
    double gain = std::numeric_limits<double>::quiet_NaN();
};

/// What `sample` learned of one value.
struct SampledValue {
    std::string name;
    double deviation = 0;              ///< of the value over the range of the variables, by the model
    double predicted_share = 0;        ///< share of its variance that models of all other designs predict
    std::vector<double> share, error;  ///< main effects (`main_effects`) and their standard errors, per variable
    std::vector<double> total;         ///< total effects: with all interactions, per variable
};
struct SampleSummary {
    std::shared_ptr<const DesignTable> table;
    std::vector<double> lower, upper;  ///< the range of each variable of the table
    std::vector<SampledValue> values;
    std::string without_effects;       ///< why there are none; empty: there are
    std::vector<std::string> remarks;  ///< what is odd, each with a remedy: equal designs, constant values, variables
                                       ///< without effect
};

struct RunResult {
    /// One word: converged | budget (evaluations or time) | progress (a fit whose progress slackened on the last level)
    /// | roundoff | no_valid_step (valid evaluations end next to the best design) | conflict (constraints that cannot
    /// be met together) | infeasible | gradient_inconsistent (with the values) | failed | evaluation_failed (a quantity
    /// gave no value) | interrupted (`RunEvents::stop_wanted` said so) | waiting (for answers from outside) | sampled
    /// (`sample`: all designs are evaluated)
    std::string status = "failed";
    std::string reason;                ///< one sentence or two: why, and what to do next
    std::vector<AwaitedCall> awaited;  ///< of status `waiting`
    std::vector<std::string> pending;  ///< of status `interrupted`: jobs that stay in a queue
    MotionAtEnd motion;
    std::string cheap_model;  ///< what the cheap models were worth on the last level, in words; empty: there is none
    std::optional<SampleSummary> samples;  ///< of `sample`
    std::vector<std::string> conflict;     ///< names of the constraints that cannot be met together; empty: none found
    int level = 0, evaluations = 0;
    double objective_start = std::numeric_limits<double>::quiet_NaN();
    double objective = std::numeric_limits<double>::quiet_NaN();  ///< of the best design
    double max_violation = std::numeric_limits<double>::quiet_NaN();
    int best_evaluation = 0;         ///< 0: there is no design
    std::vector<std::string> names;  ///< of all values
    std::vector<double> values_start, values;
    Points vertices;    ///< of the best design; empty: none
    DesignSpace space;  ///< in which it was found
    Eigen::VectorXd x;
    std::vector<LevelSummary> levels;
    /// There is a feasible design, and the run ended as it should or at a limit. A run without a valid step is done
    /// once it has improved on the start: buckling is a limit too.
    bool is_done() const {
        return status == "converged" || status == "budget" || status == "progress" || status == "roundoff" ||
               status == "sampled" || (status == "no_valid_step" && best_evaluation > 1);
    }
};

}  // namespace strake
