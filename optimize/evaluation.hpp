#pragma once
#include "optimize/combinations.hpp"
#include "optimize/response_metric.hpp"
#include "optimize/validity.hpp"

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
    /// @throws UnheldPart, InvalidInput and SolverError as PrimoShell::solve does.
    ShapeEvaluation evaluate(const Eigen::VectorXd& x, int number);
    /// Fills `evaluation.gradients` (one adjoint call), after asking quantities that differentiate separately. Where
    /// one of these fails the evaluation is quantity_failed. @pre `evaluation` is the last result and ok.
    void differentiate(ShapeEvaluation& evaluation);
    /// The next level starts from the equilibrium of the last evaluation.
    void accept();
    /// The first evaluation of a level takes over the values of the accepted shape where it is that shape (by default
    /// they are measured again).
    void take_over_values() { takes_over_ = true; }

    /// What programs gave is kept there, and taken from there. @param stop_wanted handed on to them; may be empty.
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
    /// Per differentiated value its derivative along `direction` at these vertices.
    std::optional<Eigen::VectorXd> slopes_along(const Points& vertices, const Points& direction) const;
    void measure(int number, const Eigen::VectorXd& x, ShapeEvaluation& result);
    using Function = std::function<QuantityResult(const QuantityRequest&)>;
    /// @param what is called, for the journal: the name of the quantity's first value, or that with more words.
    QuantityResult call(const Quantity& quantity, const Function& function, const std::string& what,
                        const QuantityRequest& request, const std::string& surface) const;
    QuantityResult safely(const Quantity& quantity, const Function& function, const std::string& what,
                          const QuantityRequest& request, ShapeEvaluation& result) const;
    bool wants_gradients_of(int first, const Quantity& quantity) const;
    /// Which of the quantity's values need sensitivities.
    std::vector<char> wanted_of(int first, const Quantity& quantity) const;
    bool combine(const Quantity& quantity, ShapeEvaluation& result);
    bool take_gradients(ShapeEvaluation& result);
    bool ask_for_gradients(ShapeEvaluation& result);
    bool own_sensitivities_usable(int i, Eigen::VectorXd& dJ_down, ShapeEvaluation& result) const;

    const Problem& problem_;
    std::shared_ptr<const RestFacts> rest_;
    ValidityGuard guard_;
    std::vector<std::string> names_;
    std::vector<int> differentiated_;  ///< indices into names_
    Combinations combinations_;
    std::vector<int> needed_;  ///< differentiated ones and what they are made of
    DesignSpace space_;
    std::unique_ptr<PrimoShell> shell_;
    std::vector<int> shell_pin_;
    Eigen::VectorXd shell_height_, last_x_;
    std::optional<Poses> accepted_, last_;
    struct Measured {
        Points vertices;
        Eigen::VectorXd own;  ///< own variables, scaled
        std::vector<double> own_physical;
        std::vector<double> values;
        std::vector<Points> dJ_dv;
        std::vector<Eigen::VectorXd> dJ_down;
        bool has_gradients_to_come = false;
        int at = 0;  ///< number of the evaluation
        std::string surface;
        /// Of all values, as far as they came with these: where others are to come.
        std::vector<Points> known_dJ_dv;
        std::vector<Eigen::VectorXd> known_dJ_down;
    };
    bool take_over(const Eigen::VectorXd& x, ShapeEvaluation& result);
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
};

}  // namespace strake
