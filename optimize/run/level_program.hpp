#pragma once
#include "optimize/evaluate/constraints.hpp"
#include "optimize/nlp/minimizer.hpp"
#include "optimize/run/cheap_program.hpp"
#include "optimize/run/design_table.hpp"
#include "optimize/run/run_state.hpp"

/// The shape problem of a level as a nonlinear program in y = weight * x, in which every variable has the same size.
/// Internal.
namespace strake {

/// The best differentiated design of a level.
struct KnownDesign {
    Eigen::VectorXd x;
    Rank rank;
    Evaluation sample;                              ///< entries made by differences are zero in its gradients
    std::vector<ShellSensitivities> sensitivities;  ///< of the differentiated values
    Points dJ_dv;                                   ///< of the objective
    MotionConditions motion;                        ///< of the motion limit, near it
};

class LevelProgram {
public:
    /// A design of the level and what it gave; no values: it failed.
    struct SeenDesign {
        Eigen::VectorXd x;
        std::vector<double> values;
    };

    /// @throws InvalidInput: no objective, unknown names, contradicting limits, a method that needs gradients of a
    /// value that has none.
    LevelProgram(RunState& state);

    /// Names of the values whose gradients are wanted, the objective first if it is among them.
    static std::vector<std::string> differentiated_names(const Problem& problem);

    /// The program of the present level; `start` in x. `is_widened`: its ranges have become wider, and stay so where
    /// several starts are drawn in those of before.
    const NonlinearProgram& enter(const Eigen::VectorXd& start, bool is_widened = false);
    const NonlinearProgram& program() const { return program_; }
    const Eigen::VectorXd& weight() const { return weight_; }
    Eigen::VectorXd unscaled(const Eigen::VectorXd& y) const;
    /// Method model learns from the designs of all levels: those seen so far become designs of the level that is
    /// entered next. @param parent, start the same design on the level before and on this one; `prolongation` dx /
    /// d(parent's x)
    void carry_designs(const Eigen::VectorXd& parent, const Eigen::VectorXd& start,
                       const Eigen::MatrixXd& prolongation);
    /// What the folder of `start_from` has paid for counts: designs of its best one's level, as steps from that one,
    /// where this run starts. Before the first level is entered; other methods than model do nothing.
    void learn(const DesignTable& table, const Eigen::VectorXd& start);
    const ShapeEvaluation& current() const { return current_; }  ///< the last evaluation

    /// Of the present level, that searches by models have: fewer than variables where values are the same for mirror
    /// images.
    int num_directions() const { return num_directions_; }
    /// The part of a change of y that is its own mirror image, by all images for which the last search has found values
    /// to be the same; all of it where there are none.
    Eigen::VectorXd symmetric_part(const Eigen::VectorXd& change) const;

    const KnownDesign& known() const { return known_; }  ///< without sensitivities where nothing was differentiated
    /// Of the Lagrangian (as minimized) at the known design. @pre it has sensitivities of all values in it.
    ShellSensitivities lagrangian() const;
    Eigen::VectorXd lagrangian_weights() const;  ///< of the differentiated values in it
    /// All that the Lagrangian holds has sensitivities, and the method asks for them.
    bool gives_lagrangian() const;
    /// Values alone, and fields beside patches to choose from.
    bool has_choice() const;
    bool has_lagrangian() const { return !known_.sensitivities.empty() && !needs_differences_; }
    const ConstraintRows& rows() const { return rows_; }
    /// At the end of the search of this level. @param best its best evaluation, with gradients where these are known
    MotionAtEnd motion_at_end(const Evaluation& best) const;
    bool quantity_failed() const { return quantity_failed_; }
    /// What the cheap models were worth in this search; empty: there are none.
    std::string cheap_words(const MinimizeResult& result) const;
    /// The last failure left the surface sound.
    bool last_failed_in_quantity() const { return last_failed_in_quantity_; }

private:
    Eigen::MatrixXd second_curvature() const;
    Evaluation evaluate(const Eigen::VectorXd& x);
    void differentiate(Evaluation& sample);
    void limit_motion();
    void add_cheap_program();
    void add_mirror_images();
    /// Searches by models use what coarser levels have paid for.
    bool learns() const {
        const OptimizeOptions& options = state_.problem.optimize;
        return options.method == Method::model ||
               (options.method == Method::sqp && !options.descends_as_before && has_choice());
    }
    std::vector<KnownPoint> known_points();
    void use_learned();
    std::string contradiction(const std::vector<double>& at_start) const;
    Evaluation from_values(const std::vector<double>& values) const;
    void keep_slack();
    void narrow_bounds(bool is_widened);
    StepLimits step_limits(const MotionConditions& at, const FoldConditions& folds) const;
    Eigen::VectorXd limit_multipliers(const Evaluation& at) const;
    double sign() const { return state_.problem.maximize ? -1 : 1; }

    RunState& state_;
    int objective_ = 0, objective_gradient_ = -1, num_inequalities_ = 0, num_equalities_ = 0;
    std::vector<int> constrained_, gradient_row_;  ///< per constraint: its value, its gradient (-1: by differences)
    ConstraintRows rows_;
    NonlinearProgram program_;
    Eigen::VectorXd weight_;
    Eigen::VectorXd moved_y_,
        moved_x_;                 ///< the last point moved inside the motion limit, without the scaling's round-off
    double difference_step_ = 0;  ///< that the noise of the values asks for; 0: that of the case
    double slack_ = 0;  ///< share of the motion limit that designs keep, so that what is next to them is within, too
    std::unique_ptr<CheapProgram> cheap_;  ///< null: the problem has no cheap models, or the method does not use them
    std::vector<SeenDesign> seen_;         ///< of method model
    std::vector<SeenDesign> learned_;      ///< the first is that of the start; until the start has been evaluated
    struct MirrorPlane {
        SymmetryPlane plane;
        bool holds = false;  ///< all values were the same on the level before
        bool has_held = false;
        bool is_none = false;  ///< they were not when they were first compared
    };
    int num_directions_ = 0;
    static void use_mirror(MirrorPlane& mirror, bool holds) {
        mirror.is_none |= !holds && !mirror.has_held;
        mirror.has_held |= holds;
        mirror.holds = holds;
    }
    std::optional<std::vector<MirrorPlane>> mirrors_;  ///< of the surface; none: not looked for yet
    ShapeEvaluation current_;
    Eigen::VectorXd current_x_;
    Rank current_rank_;
    KnownDesign known_;
    bool has_strains_ = false;
    bool needs_differences_ = false, quantity_failed_ = false, last_failed_in_quantity_ = false;
};

/// After a level whose search has ended so: nothing is wrong for good, and there is budget left.
inline bool may_continue(const RunState& state, const MinimizeResult& level) {
    return level.stop != MinimizeStop::failed && !level.gradient_inconsistent && state.evaluations_left() > 0 &&
           state.seconds_left() > 0;
}

}  // namespace strake
