#pragma once
#include "optimize/failure_border.hpp"
#include "optimize/methods.hpp"
#include "optimize/minimizer.hpp"
#include "optimize/partial_gradient.hpp"

#include <exception>

/// What stands between NLopt and a nonlinear program: evaluates every x once, refuses NaN, keeps the cause of every
/// failure and the best point seen. Used by minimize() only.
namespace strake {

/// Why the guard ended a search.
enum class Cause {
    none,
    failure,
    fatal,
    evaluations,
    time,
    stopped,
    asked_nonfinite,
    circles,  ///< the algorithm asks for points that it knows, without end
    stalled,  ///< `patience` has run out
    exception
};

/// The guard stops a search by throwing nlopt::forced_stop; callers meet no other type of exception.
class Guard {
public:
    Guard(const NonlinearProgram& program, const MinimizeOptions& options);

    /// Sample at the free variables `z`. @throws nlopt::forced_stop with `cause` set when there is none.
    const Sample& at(const double* z, bool gradient);
    const Sample& asked(const Eigen::VectorXd& x, bool gradient);   ///< the same for all variables
    const Sample& at_all(const Eigen::VectorXd& x, bool gradient);  ///< and not by NLopt
    Eigen::VectorXd all_variables(const double* z) const;
    /// As at_all, without an exception: false, `cause` is set.
    bool try_at(const Eigen::VectorXd& x, bool gradient, Sample& sample);

    /// The gradient at x as `at_all`, from a guess and the differences that it asks for; all differences where these
    /// fail.
    bool try_with(const Eigen::VectorXd& x, const GradientGuess& guess, Sample& sample);
    /// Pays these differences at x, whose sample is known, too.
    bool try_refined(const Eigen::VectorXd& x, const GradientGuess& guess, Sample& sample);
    /// What was guessed of the gradient at the best point is paid when it is asked for again.
    void forget_guessed();

    void tell_event(const std::string& words) const {
        if (options.on_event) options.on_event(words);
    }

    const NonlinearProgram program;  ///< with differences where the method has or takes no gradients
    const MinimizeOptions& options;
    const MethodFacts& method;
    std::vector<int> free;  ///< numbers of the variables whose bounds differ
    bool wants_gradient = true;
    /// For the present part of the search: evaluations in a row that gain less than the tolerance. 0: any number.
    void set_patience(int most) { patience_ = most, gained_at_ = evaluations; }

    int limit;           ///< of evaluations, for the present part of the search: <= options.max_evaluations
    double scale = 1;    ///< NLopt sees objective / scale
    double penalty = 0;  ///< of a unit of violation, in the merit that is told
    double best_merit = std::numeric_limits<double>::infinity();
    Eigen::VectorXd merit_x;  ///< where that was
    Eigen::VectorXd best_x;
    Sample best;
    bool has_best = false, best_feasible = false;
    double best_violation = 0;
    double lowest = std::numeric_limits<double>::infinity();  ///< and highest objective seen
    double highest = -std::numeric_limits<double>::infinity();
    Cause cause = Cause::none;
    std::exception_ptr exception;
    std::string failure;
    Eigen::VectorXd failed_x;
    bool failed_on_the_way = false;  ///< the last failure says nothing of where others fail (`Sample::is_of_step`)
    int evaluations = 0, failures = 0;
    FailureBorder border;

private:
    [[noreturn]] void stop(Cause why);
    [[noreturn]] void fail_gradient(const Eigen::VectorXd& x, const std::string& why);
    const Sample& sample_at(const Eigen::VectorXd& x, bool gradient);
    Sample count_and_evaluate(const Eigen::VectorXd& x);
    Sample sample_of(const Eigen::VectorXd& x);
    void evaluate(const Eigen::VectorXd& x);
    void rank(const Eigen::VectorXd& x);
    void differentiate(const Eigen::VectorXd& x);
    void add_differences(const Eigen::VectorXd& x, Sample& sample);
    void check_gradient(const Eigen::VectorXd& x);
    double now() const;  ///< seconds
    bool tell(const MinimizeStep& step) const { return !options.on_step || options.on_step(step); }

    const GradientGuess* guess_ = nullptr;  ///< of the next gradient
    bool is_refined_ = false;               ///< what the program itself knows of that gradient is in the guess
    Sample last_;
    Eigen::VectorXd last_x_;
    long asked_ = 0;
    int patience_ = 0, gained_at_ = 0;
    bool told_outside_ = false;
    double begin_ = now();
};

}  // namespace strake
