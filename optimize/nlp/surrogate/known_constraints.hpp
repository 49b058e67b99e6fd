#pragma once
#include "optimize/nlp/program/guard.hpp"

#include <functional>

/// Constraints that the search by models needs no model for. Internal.
namespace strake {

struct QuadraticModel;

/// Those that the cheap program beside the expensive one tells exactly (`LowFidelityValue::same`), with their slopes
/// where one looks from. Asks the cheap program only.
class KnownConstraints {
public:
    explicit KnownConstraints(const Guard& guard);

    const std::vector<Eigen::Index>& rows() const { return rows_; }  ///< of all constraints
    bool has(Eigen::Index row) const;

    struct Found {
        Eigen::VectorXd x, constraints;  ///< all constraints, of which those of `rows` are known
        Eigen::MatrixXd jacobian;        ///< by all variables; empty: not known, or not asked for
        bool has_slopes() const { return jacobian.size() > 0; }
    };
    /// Nothing: there is no shape at x, or no such row.
    std::optional<Found> at(const Eigen::VectorXd& x, bool with_slopes) const;
    /// Largest violation of the known ones, scaled.
    double violation(const Found& found) const;
    double tolerance() const { return 0.5 * guard_.options.constraint_tolerance; }
    bool are_met(const Found& found) const { return violation(found) <= tolerance(); }
    /// The design nearest to x, in the metric and within the bounds, that meets them: by the slopes of `near`,
    /// corrected by the values found while these come nearer. x where no design found violates them less.
    Eigen::VectorXd nearest(const Eigen::VectorXd& x, const Found& near) const;
    /// The design nearest to x, in the metric and within the bounds, that meets them by the slopes of `near`, and
    /// `limits` on steps from `from`; where none does, one that violates them little. x where rounding hides it.
    Eigen::VectorXd nearest_by_slopes(const Eigen::VectorXd& x, const Found& near, const Eigen::VectorXd& from,
                                      const StepLimits& limits) const;

private:
    QuadraticModel way_to_nearest(const Eigen::VectorXd& x, const Found& near) const;
    Eigen::VectorXd after(const Eigen::VectorXd& x, const Eigen::VectorXd& step) const;
    bool tells_slopes() const;
    /// False: it threw what counts as a failure.
    static bool has_done(const std::function<void()>& call, bool may_throw);
    const Guard& guard_;
    std::vector<Eigen::Index> rows_;
    mutable std::vector<Found> recent_;  ///< without slopes
};

}  // namespace strake
