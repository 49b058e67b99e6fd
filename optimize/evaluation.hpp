#pragma once
#include "optimize/combinations.hpp"
#include "optimize/design_calls.hpp"
#include "optimize/response_metric.hpp"
#include "optimize/validity.hpp"

#include <deque>

/// One evaluation: x -> loads -> equilibrium -> a valid surface -> values, and by one adjoint call their gradients.
namespace strake {

class Journal;

enum class EvaluationStatus {
    ok,
    not_converged,   ///< the shell found no equilibrium
    unstable,        ///< it found one that is no stable minimum
    invalid,         ///< inverted, collapsed or folded: the surface is not handed on
    quantity_failed  ///< a quantity gave no value
};
std::string to_string(EvaluationStatus status);

struct ShapeEvaluation {
    EvaluationStatus status = EvaluationStatus::not_converged;
    std::string reason;                    ///< why it is not ok
    bool may_go_on = true;                 ///< a quantity failed, but says that this is no reason to end the run
    Points vertices;                       ///< n x 3; empty unless a valid surface was reached
    std::vector<double> values;            ///< in the order of `ShapeEvaluator::names()`; empty unless ok
    std::vector<Points> dJ_dv;             ///< of the differentiated values, in their order; empty without gradients
    bool has_gradients_to_come = false;    ///< dJ_dv is still empty: `differentiate` asks for it
    std::vector<Eigen::VectorXd> dJ_down;  ///< the same by the own variables; NaN: not given (with finite_differences)
    Eigen::MatrixXd gradients;  ///< differentiated values x variables, once `differentiate` was called; NaN as above
    std::vector<ShellSensitivities> sensitivities;  ///< of the differentiated values, from the same call
    double max_displacement = 0;                    ///< from the start surface, length
    bool is_taken_over = false;  ///< the values are those of the same shape on the level before; nothing was called
    std::vector<std::string> remarks;  ///< of the quantities, for the log
    std::string surface;               ///< with a journal: hash of the surface; empty: none
};

/// Keeps the shell, its factor and the poses of the last shapes between evaluations. Not thread-safe.
class ShapeEvaluator {
public:
    /// @param differentiated names of the values whose gradients are wanted; empty: never ask a quantity for any.
    /// @throws InvalidInput on unknown or repeated names.
    ShapeEvaluator(const Problem& problem, std::shared_ptr<const RestFacts> rest,
                   const std::vector<std::string>& differentiated);

    /// Evaluates in this space from now on; the poses are kept.
    void enter(const DesignSpace& space);

    /// Deforms and evaluates; gradients of quantities come along, those by x only with `differentiate`.
    /// @param number of the evaluation within the run, for external programs. Failing is a result.
    /// A system that cannot be solved is a failure like any other. @throws UnheldPart, InvalidInput.
    ShapeEvaluation evaluate(const Eigen::VectorXd& x, int number);
    /// These designs will be asked for next, as the evaluations from `first` on: where programs may run in parallel,
    /// the shapes are made one after another in this order and the programs called as slots are free. If others are
    /// asked for, what was begun is given up.
    void expect(const std::vector<Eigen::VectorXd>& designs, int first);
    /// Fills `evaluation.gradients` (one adjoint call), after asking quantities that differentiate separately. Where
    /// one of these fails the evaluation is quantity_failed. @pre `evaluation` is the last result and ok.
    void differentiate(ShapeEvaluation& evaluation);
    /// The next level starts from the equilibrium of the last evaluation.
    void accept();
    /// The first evaluation of a level takes over the values of the accepted shape where it is that shape (by default
    /// they are measured again).
    void take_over_values() { takes_over_ = true; }

    /// What programs gave is kept there, and taken from there. @param stop_wanted handed on to them, and asked after
    /// every iteration of a deformation; may be empty.
    void keep_calls(Journal* journal, std::function<bool()> stop_wanted) {
        journal_ = journal;
        stop_wanted_ = std::move(stop_wanted);
    }

    /// Before the first evaluation: from these poses to the equilibrium of x, where evaluations start then.
    /// @return its vertices; empty where there is none, with the reason.
    Points begin_from(const Poses& poses, const Eigen::VectorXd& x, std::string& reason);
    const Poses& poses() const { return *last_; }  ///< @pre the last evaluation is ok

    /// The metric at x times d (`present_product`); empty with strains or stiffness among the variables, and where x,
    /// which an evaluation has reached before, is not reached again.
    Eigen::VectorXd metric_product(const Eigen::VectorXd& x, const Eigen::VectorXd& d);

    /// Second derivative, along `step` of the loads of `finer` at x, of the sum of weight * value over the
    /// differentiated values: from their vertex sensitivities a hair along the linear response. No program is called:
    /// none where one of the values comes from a program, where other variables than loads would move, and where there
    /// is no shape at x.
    std::optional<double> curvature_along(const Eigen::VectorXd& x, const DesignSpace& finer,
                                          const Eigen::VectorXd& step, const Eigen::VectorXd& weight);

    const std::vector<std::string>& names() const { return names_; }
    int index_of(const std::string& name) const;  ///< @throws InvalidInput with the known names
    PrimoShell& shell() { return *shell_; }       ///< at the equilibrium of the last evaluation, if that was ok
    const DesignSpace& space() const { return space_; }

private:
    /// Where the equilibrium at x is sought from: the nearest (in the metric) of the shapes that this level has reached
    /// last, else the accepted one; none before the first evaluation of a run.
    const Poses* nearest_known(const Eigen::VectorXd& x) const;
    void build_shell(const ShellDemand& demand);
    bool deform(const Eigen::VectorXd& x, ShapeEvaluation& result);
    /// A design on its way: deformed, and its quantities asked.
    struct Design {
        int number = 0;
        Eigen::VectorXd x;
        ShapeEvaluation result;
        std::optional<Poses> poses;          ///< none: there is no shape
        std::unique_ptr<DesignCalls> calls;  ///< none: there is no shape, or its values are taken over
        std::exception_ptr thrown;           ///< by the deformation
        bool is_ready() const { return !calls || calls->is_ready(); }
    };
    Design begin(const Eigen::VectorXd& x, int number);
    Design next(const Eigen::VectorXd& x, int number);  ///< where it is expected, its programs have run already
    Design take_first();                                ///< of `ahead_`, once its programs have answered
    bool begin_expected();
    void advance();
    void give_up();
    void forget_expected(int number);
    [[noreturn]] void interrupt();  ///< @throws Interrupted, with the jobs that go on
    // quantity_calls.cpp
    QuantityResult call(const Quantity& quantity, const QuantityRequest& request) const;
    std::shared_ptr<const DesignCalls::Facts> facts_of(const Eigen::VectorXd& x, int number,
                                                       const Points& vertices) const;
    std::unique_ptr<DesignCalls> calls_of(const std::vector<Quantity>& quantities,
                                          std::shared_ptr<const DesignCalls::Facts> facts) const;
    bool wants_gradients_of(std::size_t quantity) const;
    bool are_gradients_apart(std::size_t quantity) const;
    void set_gradient_calls();
    QuantityResult taken(DesignCalls& calls, std::size_t quantity, bool wants_values, ShapeEvaluation& result) const;
    void measure(Design& design);
    bool ask_for_gradients(ShapeEvaluation& result);
    bool take_gradients(ShapeEvaluation& result);
    /// Per differentiated value its derivative along `direction` at these vertices.
    std::optional<Eigen::VectorXd> slopes_along(const Points& vertices, const Points& direction) const;
    /// Which of the quantity's values need sensitivities.
    std::vector<char> wanted_of(std::size_t quantity) const;
    bool combine(const Quantity& quantity, const std::vector<double>& own, ShapeEvaluation& result);
    bool own_sensitivities_usable(int i, Eigen::VectorXd& dJ_down, ShapeEvaluation& result) const;

    const Problem& problem_;
    std::shared_ptr<const RestFacts> rest_;
    ValidityGuard guard_;
    std::vector<std::string> names_;
    std::vector<int> differentiated_;  ///< indices into names_
    Combinations combinations_;
    std::vector<int> needed_;  ///< differentiated ones and what they are made of
    /// As the problem's quantities: what those are asked that differentiate separately; the others nothing.
    std::vector<Quantity> gradient_calls_;
    DesignSpace space_;
    std::unique_ptr<PrimoShell> shell_;
    std::vector<int> shell_pin_;
    Eigen::VectorXd shell_height_, last_x_;
    Eigen::VectorXd shell_x_;  ///< of the equilibrium that the shell is at
    std::optional<Poses> accepted_, last_;
    struct Measured {
        std::shared_ptr<const DesignCalls::Facts> facts;  ///< null: nothing is measured
        Eigen::VectorXd own;                              ///< own variables, scaled
        std::vector<double> values;
        std::vector<Points> dJ_dv;  ///< of the differentiated values
        std::vector<Eigen::VectorXd> dJ_down;
        bool has_gradients_to_come = false;
        /// Where they are to come: those of all values, as far as they came with these.
        std::vector<Points> known_dJ_dv;
        std::vector<Eigen::VectorXd> known_dJ_down;
    };
    bool take_over(const Eigen::VectorXd& x, ShapeEvaluation& result) const;
    Measured last_measured_, accepted_measured_;
    bool takes_over_ = false;
    Journal* journal_ = nullptr;
    std::function<bool()> stop_wanted_;
    bool enters_ = false;  ///< no evaluation yet in this space
    struct KnownShape {
        Eigen::VectorXd x;
        Poses poses;
    };
    std::vector<KnownShape> known_;  ///< of this level, the latest last
    int parallel_ = 1;               ///< most designs whose programs run at the same time
    std::deque<std::pair<int, Eigen::VectorXd>> expected_;
    std::deque<Design> ahead_;  ///< begun and not yet asked for, and the one that is
};

}  // namespace strake
