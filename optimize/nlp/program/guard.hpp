#pragma once
#include "optimize/nlp/program/failure_border.hpp"
#include "optimize/nlp/program/gradient_evidence.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "optimize/nlp/program/minimize_options.hpp"
#include "optimize/nlp/program/partial_gradient.hpp"

#include <exception>

/// Stands between the algorithms and a nonlinear program: evaluates every x once, refuses NaN, keeps the cause of every
/// failure and the best point seen. Used by minimize() only.
namespace strake {

/// Why the guard ended a search.
enum class StopCause {
    none,
    failure,
    fatal,
    evaluations,
    time,
    stopped,
    nonfinite_point,  ///< the algorithm asked for one
    repeated_points,  ///< the algorithm asks for known points without end
    stalled,          ///< `patience` has run out
    exception
};

/// How a search ends that its guard has ended.
struct GuardEnd {
    MinimizeStop stop;
    std::string reason;
};

/// The guard stops a search by throwing nlopt::forced_stop; callers meet no other type of exception.
class Guard {
public:
    Guard(const NonlinearProgram& program, const MinimizeOptions& options);

    /// The evaluation at the free variables `z`. @throws nlopt::forced_stop with `cause` set when there is none.
    const Evaluation& at(const double* z, bool gradient);
    const Evaluation& requested(const Eigen::VectorXd& x, bool gradient);  ///< the same for all variables
    const Evaluation& at_all(const Eigen::VectorXd& x, bool gradient);     ///< the same, not for NLopt
    Eigen::VectorXd all_variables(const double* z) const;
    /// As at_all, without an exception: false, `cause` is set.
    bool try_at(const Eigen::VectorXd& x, bool gradient, Evaluation& evaluation);

    /// Where `at_all` evaluates for x, which is within the bounds: x, or the point that the program moves it to.
    Eigen::VectorXd inside(const Eigen::VectorXd& x);
    /// These points, which `inside` gave, are asked for next, in this order: they are not moved again.
    void expect(const std::vector<Eigen::VectorXd>& points);
    /// `NonlinearProgram::is_defined` without an exception: true, `cause` is set.
    bool is_defined(const Eigen::VectorXd& x);
    /// The program refuses x: a failure that the border learns of, and that costs no evaluation. Without an exception:
    /// false, `cause` is set.
    bool is_refused(const Eigen::VectorXd& x);
    /// `NonlinearProgram::beyond` without an exception: `cause` is set, and there are no rows.
    StepLimits beyond(const Eigen::VectorXd& from, const Eigen::VectorXd& to);

    /// Like `at_all` with the gradient, which is the guess corrected by the differences that it names; by all
    /// differences where these fail.
    bool try_with(const Eigen::VectorXd& x, const GradientGuess& guess, Evaluation& evaluation);
    /// Adds these differences at x, where the values are known already.
    bool try_refined(const Eigen::VectorXd& x, const GradientGuess& guess, Evaluation& evaluation);
    /// The guessed part of the best point's gradient is evaluated when the gradient is asked for again.
    void forget_guessed();

    /// Decreases from this objective on that are as good as none: `objective_tolerance` of what has been gained, or
    /// what the values do not resolve.
    double decrease_tolerance(double objective) const;
    /// By this objective, in this search and those that it continues.
    double gained(double objective) const;
    /// What NLopt's methods minimize is the objective without this: their tolerances are relative to what they see.
    double offset() const { return options.is_relative_to_objective ? 0 : start_objective; }
    /// The search wants gradients, and not all of them are differences.
    bool has_own_gradients() const {
        return wants_gradient &&
               !(program.differences && program.differences->objective && program.differences->rows.empty());
    }

    /// "the limit of evaluations is reached (9)", with `MinimizeOptions::scope`.
    std::string limit_words() const;
    /// For `cause`; what is neither a limit nor a wish is a failure. @pre cause is not none
    GuardEnd end_by_cause() const;

    void report_event(const std::string& words) const {
        if (options.on_event) options.on_event(words);
    }

    NonlinearProgram program;  ///< with differences where the method has or takes no gradients
    const MinimizeOptions& options;
    const MethodFacts& method;
    std::vector<int> free;  ///< numbers of the variables whose bounds differ
    bool wants_gradient = true;
    /// Maximum number of evaluations in a row that gain less than the tolerance, for the present part of the search.
    /// 0: any number.
    void set_patience(int evaluations_in_row) { patience_ = evaluations_in_row, gained_at_ = evaluations; }

    int limit;           ///< of evaluations, for the present part of the search: at most the larger one of
                         ///< options.max_evaluations and options.limit_while_gaining
    double scale = 1;    ///< NLopt sees objective / scale
    double penalty = 0;  ///< of a unit of violation, in the merit that is reported
    double best_merit = std::numeric_limits<double>::infinity();  ///< of all points seen, by the present penalty
    Eigen::VectorXd merit_x;                                      ///< where that was
    Eigen::VectorXd best_x;
    Evaluation best;
    bool has_best = false, best_feasible = false;
    double best_violation = 0;
    double lowest = std::numeric_limits<double>::infinity();  ///< and highest objective seen
    double highest = -std::numeric_limits<double>::infinity();
    StopCause cause = StopCause::none;
    std::exception_ptr exception;
    std::string failure;
    Eigen::VectorXd failed_x;
    bool failed_on_the_way = false;  ///< the last failure says nothing about its point (`Evaluation::is_of_step`)
    int evaluations = 0, failures = 0;
    FailureBorder border;
    GradientEvidence evidence;     ///< of a program with gradients of its own
    double largest_gradient = 0;   ///< of the Lagrangian, in the dual of the metric
    bool may_use_reserve = false;  ///< of the two evaluations that a contradicted gradient's check needs
    double start_objective = std::numeric_limits<double>::quiet_NaN();

private:
    [[noreturn]] void stop(StopCause why);
    [[noreturn]] void fail_gradient(const Eigen::VectorXd& x, const std::string& why);
    const Evaluation& evaluation_at(const Eigen::VectorXd& x, bool gradient);
    Evaluation count_and_evaluate(const Eigen::VectorXd& x);
    Evaluation evaluation_of(const Eigen::VectorXd& x);
    void evaluate(const Eigen::VectorXd& x);
    void rank(const Eigen::VectorXd& x);
    void remember_merit(const Eigen::VectorXd& x);
    void differentiate(const Eigen::VectorXd& x);
    void add_differences(const Eigen::VectorXd& x, Evaluation& evaluation);
    void check_gradient(const Eigen::VectorXd& x);
    /// Once: a longer step of the differences, where the values carry noise. True: it is another one now.
    bool follow_noise(const Eigen::VectorXd& x, const Evaluation& at,
                      const std::function<Evaluation(const Eigen::VectorXd& x)>& evaluate);
    double now() const;  ///< seconds
    int reserve() const;
    bool report(const MinimizeStep& step) const { return !options.on_step || options.on_step(step); }

    const GradientGuess* guess_ = nullptr;  ///< of the next gradient
    bool is_refined_ = false;               ///< the guess contains the gradients that the program gives
    Evaluation last_;
    Eigen::VectorXd last_x_;
    std::vector<Eigen::VectorXd> failed_since_value_;  ///< points without values since the last one with
    /// Objectives and violations than which no other point seen has both less.
    struct MeritPoint {
        double objective, violation;
        Eigen::VectorXd x;
    };
    std::vector<MeritPoint> merit_points_;
    Eigen::VectorXd asked_, moved_;  ///< of the last call of `inside` that asked the program
    std::vector<Eigen::VectorXd> expected_;
    long requests_ = 0;
    int patience_ = 0, gained_at_ = 0;
    bool reported_outside_ = false, knows_noise_ = false;
    double begin_ = now();
};

}  // namespace strake
