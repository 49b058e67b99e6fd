#pragma once
#include "optimize/evaluate/evaluation_queue.hpp"
#include "optimize/evaluate/fold_conditions.hpp"
#include "optimize/evaluate/limited_motion.hpp"
#include "optimize/evaluate/quantity_calls.hpp"
#include "optimize/evaluate/shape_solver.hpp"

/// One evaluation: x -> loads -> equilibrium -> a valid surface -> values, and by one adjoint call their gradients.
namespace strake {

/// Joins the shape (ShapeSolver), the values (QuantityCalls) and what runs in parallel (EvaluationQueue). Not
/// thread-safe.
class ShapeEvaluator {
public:
    /// @param differentiated names of the values whose gradients are wanted; empty: never ask a quantity for any.
    /// @throws InvalidInput on unknown or repeated names.
    ShapeEvaluator(const Problem& problem, std::shared_ptr<const RestFacts> rest,
                   const std::vector<std::string>& differentiated);

    /// Shapes beyond the problem's motion limit are refused from now on: before the first evaluation.
    void limit_motion();
    const MotionLimit& motion_limit() const { return solver_.limit(); }
    /// Designs do not follow each other (`ShapeSolver::solve_each_from_datum`).
    void solve_each_from_datum() { solver_.solve_each_from_datum(); }
    /// Ends the run between two evaluations: stops all programs. @throws Interrupted, with the jobs that are pending.
    [[noreturn]] void interrupt() { queue_.interrupt(); }
    /// x, or where its shape does not keep `slack` of the motion limit, has an edge above `angle` (degrees), or its
    /// fields fold space, a design near it whose shape is within, if there is one (`moved_inside`).
    Eigen::VectorXd within(const Eigen::VectorXd& x, double slack, double angle = EdgeFolds::kept);
    /// There is a shape at x, valid and within the motion limit.
    bool has_shape(const Eigen::VectorXd& x);
    /// Why the surface of the equilibrium at x is not valid, or is beyond the motion limit; empty: it is neither, or
    /// there is no equilibrium.
    std::string refusal(const Eigen::VectorXd& x);
    /// The shape at x has an equilibrium that does not keep `slack` of the motion limit, or it or its fields fold.
    bool is_beyond(const Eigen::VectorXd& x, double slack);
    /// `strake::motion_conditions`: of vertices near their limits, and of edges that nearly fold.
    MotionConditions motion_conditions(const Eigen::VectorXd& x, double min_used, const EdgeFolds::Angles& angles = {});
    /// Of triangles with a determinant below `below` at x; none without a motion limit.
    FoldConditions fold_conditions(const Eigen::VectorXd& x, double below) const;
    /// On steps from `from`, of triangles that would fold at `to`; none without a motion limit.
    FoldConditions fold_conditions_between(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const;

    /// Evaluates in this space from now on; the poses are kept.
    void enter(const DesignSpace& space);
    /// Of the space that it is in, which is this one but for its ranges.
    void set_ranges(const DesignSpace& space);

    /// Deforms and evaluates; gradients of quantities come along, those by x only with `differentiate`.
    /// @param number of the evaluation within the run, for external programs. Failing is a result.
    /// A system that cannot be solved is a failure like any other. @throws UnheldPart, InvalidInput.
    ShapeEvaluation evaluate(const Eigen::VectorXd& x, int number);
    /// Vertices of the equilibrium at x, valid or not; empty: there is none. `evaluate` at the same x goes on from it.
    Points equilibrium(const Eigen::VectorXd& x);
    /// These designs will be asked for next, as the evaluations from `first` on: where programs may run in parallel,
    /// the shapes are made one after another in this order and the programs called when a concurrent call is free. If
    /// others are asked for, what was begun is cancelled.
    void expect(const std::vector<Eigen::VectorXd>& designs, int first) { queue_.expect(designs, first); }
    /// The same where they are made one by one, when a concurrent call is free. @param design by the evaluation's
    /// number; nothing: none for now.
    void expect(std::function<std::optional<Eigen::VectorXd>(int number)> design, int first) {
        queue_.expect(std::move(design), first);
    }
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
    /// @param forgets_dropped calls of designs that are no longer expected are forgotten there, too.
    void keep_calls(Journal* journal, const std::function<bool()>& stop_wanted, bool forgets_dropped = true);

    /// Before the first evaluation: from these poses to the equilibrium of x, where evaluations start then.
    /// @return its vertices; empty where there is none, with the reason.
    Points begin_from(const Poses& poses, const Eigen::VectorXd& x, std::string& reason);
    const Poses& poses() const { return *solver_.last(); }  ///< @pre the last evaluation is ok

    /// The metric at x times d (`present_product`); empty with strains or stiffness among the variables, and where x,
    /// which an evaluation has reached before, is not reached again.
    Eigen::VectorXd metric_product(const Eigen::VectorXd& x, const Eigen::VectorXd& d);

    /// Second derivative, along `step` of the loads of `finer` at x, of the sum of weight * value over the
    /// differentiated values: from their vertex sensitivities a hair along the linear response. No program is called:
    /// none where one of the values comes from a program, where other variables than loads would move, and where there
    /// is no shape at x.
    std::optional<double> curvature_along(const Eigen::VectorXd& x, const DesignSpace& finer,
                                          const Eigen::VectorXd& step, const Eigen::VectorXd& weight);

    const std::vector<std::string>& names() const { return calls_.names(); }
    int index_of(const std::string& name) const {
        return calls_.index_of(name);
    }  ///< @throws InvalidInput with the known names
    /// At the equilibrium of the last evaluation, if that was ok; null: the problem has none.
    PrimoShell* shell() { return solver_.shell(); }
    const DesignSpace& space() const { return solver_.space(); }

private:
    /// The values of a shape, kept beside its poses.
    struct Measured {
        std::shared_ptr<const DesignCalls::Facts> facts;  ///< null: nothing is measured
        Eigen::VectorXd parameters;                       ///< scaled
        std::vector<double> values;
        std::vector<Points> dJ_dv;  ///< of the differentiated values
        std::vector<Eigen::VectorXd> dJ_dp;
        bool has_gradients_to_come = false;
        /// Where they are to come: those of all values, as far as they came with these.
        std::vector<Points> known_dJ_dv;
        std::vector<Eigen::VectorXd> known_dJ_dp;
    };
    bool deform(const Eigen::VectorXd& x, ShapeEvaluation& result);
    QueuedDesign begin(const Eigen::VectorXd& x, int number);
    bool take_over(const Eigen::VectorXd& x, ShapeEvaluation& result) const;
    void measure(QueuedDesign& design);
    bool combine(const Quantity& quantity, const std::vector<double>& parameters, ShapeEvaluation& result);
    bool ask_for_gradients(ShapeEvaluation& result);
    bool take_gradients(ShapeEvaluation& result);
    bool parameter_derivatives_usable(int i, Eigen::VectorXd& dJ_dp, ShapeEvaluation& result) const;

    const Problem& problem_;
    std::shared_ptr<const RestFacts> rest_;
    ShapeSolver solver_;
    QuantityCalls calls_;
    Measured last_measured_, accepted_measured_;
    bool takes_over_ = false;
    bool enters_ = false;  ///< no evaluation yet in this space
    std::function<bool()> stop_wanted_;
    Eigen::VectorXd inside_x_;  ///< the last design of this space with a shape within the motion limit; empty: none
    Journal* journal_ = nullptr;
    EvaluationQueue queue_;  ///< last: its calls use all the others
};

}  // namespace strake
