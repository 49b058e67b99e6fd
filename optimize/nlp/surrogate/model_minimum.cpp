#include "optimize/nlp/surrogate/model_minimum.hpp"

#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/sqp/sqp.hpp"

#include <cmath>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int max_evaluations = 60;            ///< of the models
constexpr double tolerance = 1e-5;             ///< of the decrease, and of steps over the radius
constexpr double constraint_tolerance = 1e-7;  ///< so that what meets the models' constraints meets the program's

/// The models as a nonlinear program in the free variables. Rows: the program's inequalities, the radius, the border
/// of failures, conditions on the step; then equalities.
class ModelProgram {
public:
    ModelProgram(const NonlinearProgram& program, const SampledPoints& points, const LocalModels& models,
                 const ProposalRegion& region, double deviations)
        : program_(program), points_(points), models_(models), region_(region), deviations_(deviations) {}

    NonlinearProgram as_program(const VectorXd& from) const {
        const auto& free = points_.free();
        NonlinearProgram p;
        p.start = points_.variables(from)(free);
        p.lower = program_.lower(free);
        p.upper = program_.upper(free);
        p.metric = metric_of(program_)(free, free);
        p.num_inequalities = program_.num_inequalities + more();
        p.num_equalities = program_.num_equalities;
        p.evaluate = [this](const VectorXd& y) { return values(full(y)); };
        p.differentiate = [this](const VectorXd& y, Evaluation& at) { add_slopes(full(y), at); };
        return p;
    }
    VectorXd full(const VectorXd& y) const {
        VectorXd x = program_.start;
        x(points_.free()) = y;
        return x;
    }

private:
    int first_limit() const { return program_.num_inequalities + (region_.cut ? 2 : 1); }
    Eigen::Index num_limits() const { return region_.limits.values.size(); }
    int more() const { return first_limit() + static_cast<int>(num_limits()) - program_.num_inequalities; }
    /// So that the deviation has a slope where it is zero.
    double floor() const { return 1e-12 * models_[0].scale() * models_[0].scale(); }
    int row_of(Eigen::Index constraint) const {
        const int i = static_cast<int>(constraint);
        return i < program_.num_inequalities ? i : i + more();
    }

    Evaluation values(const VectorXd& x) const {
        const VectorXd z = points_.whitened(x), step = z - region_.centre;
        const int inequalities = program_.num_inequalities;
        Evaluation at;
        at.objective = models_[0].mean(z);
        if (deviations_ > 0) at.objective -= deviations_ * std::sqrt(models_[0].variance(z) + floor());
        at.constraints.resize(models_.size() - 1 + more());
        for (Eigen::Index i = 0; i + 1 < models_.size(); ++i)
            at.constraints[row_of(i)] =
                models_[i + 1].mean(z) + region_.correction(i, z) + (i < inequalities ? region_.margin[i] : 0.0);
        at.constraints[inequalities] = 0.5 * (step.squaredNorm() / (region_.radius * region_.radius) - 1);
        if (region_.cut)
            at.constraints[inequalities + 1] = (region_.cut->normal.dot(x) - region_.cut->limit) / region_.radius;
        if (num_limits() > 0)
            at.constraints.segment(first_limit(), num_limits()) =
                (region_.limits.values + region_.limits.slopes * step) / region_.radius;
        return at;
    }

    void add_slopes(const VectorXd& x, Evaluation& at) const {
        const VectorXd z = points_.whitened(x), step = z - region_.centre;
        const int inequalities = program_.num_inequalities;
        const auto by_y = [&](const VectorXd& g) -> VectorXd { return points_.U().transpose() * g; };
        VectorXd g = models_[0].gradient(z);
        if (deviations_ > 0)
            g -= deviations_ / (2 * std::sqrt(models_[0].variance(z) + floor())) * models_[0].variance_gradient(z);
        at.gradient = by_y(g);
        at.jacobian.resize(at.constraints.size(), g.size());
        for (Eigen::Index i = 0; i + 1 < models_.size(); ++i) {
            VectorXd slope = models_[i + 1].gradient(z);
            if (region_.tilt.size() > 0) slope += region_.tilt.row(i).transpose();
            at.jacobian.row(row_of(i)) = by_y(slope).transpose();
        }
        at.jacobian.row(inequalities) = by_y(step / (region_.radius * region_.radius)).transpose();
        if (region_.cut)
            at.jacobian.row(inequalities + 1) = region_.cut->normal(points_.free()).transpose() / region_.radius;
        if (num_limits() > 0)
            at.jacobian.middleRows(first_limit(), num_limits()) = region_.limits.slopes * points_.U() / region_.radius;
    }

    const NonlinearProgram& program_;
    const SampledPoints& points_;
    const LocalModels& models_;
    const ProposalRegion& region_;
    double deviations_;
};

}  // namespace

double ProposalRegion::correction(Eigen::Index row, const VectorXd& z) const {
    return tilt.size() > 0 ? offset[row] + tilt.row(row).dot(z - centre) : offset[row];
}

VectorXd model_minimum(const NonlinearProgram& program, const SampledPoints& points, const LocalModels& models,
                       const ProposalRegion& region, double deviations, const VectorXd& from) {
    const ModelProgram modelled(program, points, models, region, deviations);
    const NonlinearProgram p = modelled.as_program(from);
    MinimizeOptions how;
    how.max_evaluations = max_evaluations;
    how.constraint_tolerance = constraint_tolerance;
    how.confirm = false;
    how.first_step = 0.5 * region.radius;
    how.objective_tolerance = tolerance;
    how.step_tolerance = tolerance * region.radius;
    how.clock = [] { return 0.0; };
    Guard inner(p, how);
    Evaluation at;
    if (inner.try_at(p.start, true, at)) minimize_by_sqp(inner);
    return points.whitened(modelled.full(inner.best_x));
}

}  // namespace strake
