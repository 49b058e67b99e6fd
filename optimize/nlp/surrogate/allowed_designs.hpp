#pragma once
#include "optimize/nlp/surrogate/known_constraints.hpp"

/// Which designs are allowed, as far as that is known before they are evaluated. Internal to the search by models.
namespace strake {

class SampledPoints;

/// By constraints that a cheap program tells exactly, and by the limit of motion (`NonlinearProgram::beyond`):
/// conditions on steps from where one looks from, learned from the steps that would lead beyond it. Asks the cheap
/// program, and the expensive one for its limit and whether it is defined only.
class AllowedDesigns {
public:
    explicit AllowedDesigns(Guard& guard) : guard_(guard), known_(guard) {}

    const KnownConstraints& known() const { return known_; }
    /// Looks from x, a design that has been evaluated. False: what is known there was known already.
    bool look_from(const Eigen::VectorXd& x);
    /// What is known there.
    const std::optional<KnownConstraints::Found>& here() const { return here_; }
    bool knows_slopes() const { return here_ && here_->has_slopes(); }
    /// One looks from x, which misses what is known exactly.
    bool is_beside(const Eigen::VectorXd& x) const {
        return knows_slopes() && here_->x == x && known_.violation(*here_) > known_.tolerance();
    }
    /// The meaning of earlier runs: limits are met by turns, and shapes are not looked for.
    bool has_turns() const { return guard_.options.limits_by_models || guard_.options.limits_by_turns; }

    /// Adds to `limits` the conditions that the step to x violates. False: there are none, or the guard has stopped.
    bool limit_step_to(const Eigen::VectorXd& x, StepLimits& limits);
    struct Shape {
        Eigen::VectorXd x;
        bool is_shortened = false;
    };
    /// Where x is evaluated (`Guard::inside`); where that is not defined, a shorter way there, down to a sixtieth.
    Shape with_shape(const Eigen::VectorXd& x);
    /// The same in the directions of the search alone (`SampledPoints::restrict_to`): limits lead aside of them, and
    /// each way back meets the limits by less.
    Shape within(const SampledPoints& points, const Eigen::VectorXd& x);
    /// A design next to x, in the metric, that is allowed, where it is evaluated: from x by the slopes of both kinds of
    /// limits, so that they are met together, then from what is found (Newton's method), until the constraints are met.
    /// The one of least violation where that ends.
    Eigen::VectorXd nearest(const Eigen::VectorXd& x);
    /// The same as earlier runs did it: what the constraints have moved the limit of motion moves again, by turns.
    Eigen::VectorXd nearest_by_turns(const Eigen::VectorXd& x);
    /// By how much x violates what is known; infinity: it has no shape.
    double missed(const Eigen::VectorXd& x) const;

private:
    Guard& guard_;
    KnownConstraints known_;
    Eigen::VectorXd from_;
    std::optional<KnownConstraints::Found> here_;
};

}  // namespace strake
