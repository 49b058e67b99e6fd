#include "optimize/nlp/surrogate/model_minimum.hpp"

#include "optimize/nlp/model/quadratic_model.hpp"
#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/sqp/sqp.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace strake {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int max_evaluations = 60;            ///< of the models
constexpr double tolerance = 1e-5;             ///< of the decrease, and of steps over the radius
constexpr int bound_rounds = 4;                ///< that learn which bounds are met; then it is all of them
constexpr double constraint_tolerance = 1e-7;  ///< so that what meets the models' constraints meets the program's
constexpr double beyond_bound = 1e-6;          ///< in z: less is what a search that knows the bound leaves

/// A variable at one of its bounds.
struct MetBound {
    int variable;
    double sense;  ///< 1: at its upper one; -1
    bool operator==(const MetBound&) const = default;
};

/// In which coordinates y a minimum is looked for.
class Coordinates {
public:
    virtual ~Coordinates() = default;
    virtual VectorXd x(const VectorXd& y) const = 0;  ///< all variables
    virtual VectorXd z(const VectorXd& y) const = 0;
    virtual VectorXd slope(const VectorXd& by_z) const = 0;               ///< by y
    virtual MatrixXd slopes(const MatrixXd& by_z) const = 0;              ///< the same, a row each
    virtual VectorXd slope_of_variables(const VectorXd& by_x) const = 0;  ///< the same
    /// Start, bounds and metric.
    virtual void describe(NonlinearProgram& p, const VectorXd& from_z) const = 0;
    /// Conditions values + slopes.y <= 0 that stand for bounds of variables.
    virtual StepLimits bounds() const { return {}; }
    /// The bounds that y violates.
    virtual std::vector<MetBound> beyond(const VectorXd&) const { return {}; }
};

/// The free variables, with bounds of their own.
class FreeVariables : public Coordinates {
public:
    FreeVariables(const NonlinearProgram& program, const SampledPoints& points)
        : program_(program), points_(points), by_variables_(points.by_variables()) {}
    VectorXd x(const VectorXd& y) const override {
        VectorXd x = program_.start;
        x(points_.free()) = y;
        return x;
    }
    VectorXd z(const VectorXd& y) const override { return points_.whitened(x(y)); }
    VectorXd slope(const VectorXd& by_z) const override { return by_variables_.transpose() * by_z; }
    MatrixXd slopes(const MatrixXd& by_z) const override { return by_z * by_variables_; }
    VectorXd slope_of_variables(const VectorXd& by_x) const override { return by_x(points_.free()); }
    void describe(NonlinearProgram& p, const VectorXd& from_z) const override {
        const auto& free = points_.free();
        p.start = points_.variables(from_z)(free);
        p.lower = program_.lower(free);
        p.upper = program_.upper(free);
        p.metric = metric_of(program_)(free, free);
    }

private:
    const NonlinearProgram& program_;
    const SampledPoints& points_;
    MatrixXd by_variables_;
};

/// z = centre + Q y with the directions from the centre to the points that the models know, and those of trends, of
/// conditions and of the bounds that are met. All slopes are combinations of them while one length holds for all
/// coordinates, as where there are few points: a search by slopes never leaves them. With fewer points than variables
/// y is short; with more Q = 1.
class KnownDirections : public Coordinates {
public:
    KnownDirections(const NonlinearProgram& program, const SampledPoints& points, const LocalModels& models,
                    const ProposalRegion& region, const VectorXd& from_z, std::vector<MetBound> met)
        : program_(program),
          points_(points),
          met_(std::move(met)),
          centre_(region.centre),
          start_(points.variables(region.centre)),
          Q_(basis(models, region, from_z)),
          by_y_(points.free_along(Q_)) {}
    VectorXd x(const VectorXd& y) const override {
        VectorXd x = start_;
        x(points_.free()) += by_y_ * y;
        return x;
    }
    VectorXd z(const VectorXd& y) const override { return centre_ + Q_ * y; }
    VectorXd slope(const VectorXd& by_z) const override { return Q_.transpose() * by_z; }
    MatrixXd slopes(const MatrixXd& by_z) const override { return by_z * Q_; }
    VectorXd slope_of_variables(const VectorXd& by_x) const override {
        return by_y_.transpose() * VectorXd(by_x(points_.free()));
    }
    void describe(NonlinearProgram& p, const VectorXd& from_z) const override {
        constexpr double none = std::numeric_limits<double>::infinity();
        const Eigen::Index n = Q_.cols();
        p.start = Q_.transpose() * (from_z - centre_);
        p.lower = VectorXd::Constant(n, -none);
        p.upper = VectorXd::Constant(n, none);
        p.metric = MatrixXd::Identity(n, n);
    }
    StepLimits bounds() const override {
        StepLimits bounds{VectorXd(met_.size()), MatrixXd(met_.size(), Q_.cols())};
        for (std::size_t i = 0; i < met_.size(); ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            const double length = by_y_.row(met_[i].variable).norm();
            bounds.values[row] = -met_[i].sense * room(met_[i]) / length;
            bounds.slopes.row(row) = met_[i].sense / length * by_y_.row(met_[i].variable);
        }
        return bounds;
    }
    std::vector<MetBound> beyond(const VectorXd& y) const override {
        const VectorXd step = by_y_ * y;
        std::vector<MetBound> beyond;
        for (int j = 0; j < static_cast<int>(step.size()); ++j) {
            const double slack = beyond_bound * by_y_.row(j).norm();
            for (const double sense : {-1.0, 1.0})
                if (sense * (step[j] - room({j, sense})) > slack) beyond.push_back({j, sense});
        }
        return beyond;
    }

private:
    /// From the centre.
    double room(const MetBound& at) const {
        const int k = points_.free()[static_cast<std::size_t>(at.variable)];
        return (at.sense > 0 ? program_.upper[k] : program_.lower[k]) - start_[k];
    }
    MatrixXd basis(const LocalModels& models, const ProposalRegion& region, const VectorXd& from_z) const {
        const Eigen::Index d = points_.dimensions(), known = models[0].points().rows(), values = models.size();
        const Eigen::Index tilted = region.tilt.rows(), limits = region.limits.values.size();
        const auto met = static_cast<Eigen::Index>(met_.size());
        const Eigen::Index n = known + 1 + values + tilted + limits + met + (region.cut ? 1 : 0);
        if (n >= d) return MatrixXd::Identity(d, d);
        MatrixXd all(d, n);
        all.leftCols(known) = models[0].points().transpose().colwise() - centre_;
        all.col(known) = from_z - centre_;
        for (Eigen::Index i = 0; i < values; ++i) all.col(known + 1 + i) = models[i].gradient(centre_);
        if (tilted > 0) all.middleCols(known + 1 + values, tilted) = region.tilt.transpose();
        if (limits > 0) all.middleCols(known + 1 + values + tilted, limits) = region.limits.slopes.transpose();
        for (Eigen::Index i = 0; i < met; ++i) {
            const int j = points_.free()[static_cast<std::size_t>(met_[static_cast<std::size_t>(i)].variable)];
            all.col(known + 1 + values + tilted + limits + i) =
                points_.gradient_by_z(VectorXd::Unit(program_.start.size(), j));
        }
        if (region.cut) all.col(n - 1) = points_.gradient_by_z(region.cut->normal);
        for (auto column : all.colwise())
            if (const double length = column.norm(); length > 0) column /= length;
        return Eigen::HouseholderQR<MatrixXd>(all).householderQ() * MatrixXd::Identity(d, n);
    }

    const NonlinearProgram& program_;
    const SampledPoints& points_;
    std::vector<MetBound> met_;
    VectorXd centre_, start_;  ///< z, and all variables there
    MatrixXd Q_, by_y_;        ///< z and the free variables by y
};

/// The models as a nonlinear program. Rows: the program's inequalities, the radius, the border of failures, conditions
/// on the step, bounds that are met; then equalities.
class ModelProgram {
public:
    ModelProgram(const NonlinearProgram& program, const LocalModels& models, const ProposalRegion& region,
                 double deviations, const Coordinates& coordinates)
        : program_(program),
          models_(models),
          region_(region),
          deviations_(deviations),
          coordinates_(coordinates),
          bounds_(coordinates.bounds()) {}

    NonlinearProgram as_program(const VectorXd& from) const {
        NonlinearProgram p;
        coordinates_.describe(p, from);
        p.num_inequalities = program_.num_inequalities + more();
        p.num_equalities = program_.num_equalities;
        p.evaluate = [this](const VectorXd& y) { return values(y); };
        p.differentiate = [this](const VectorXd& y, Evaluation& at) { add_slopes(y, at); };
        return p;
    }

private:
    int first_limit() const { return program_.num_inequalities + (region_.cut ? 2 : 1); }
    Eigen::Index num_limits() const { return region_.limits.values.size(); }
    Eigen::Index num_bounds() const { return bounds_.values.size(); }
    Eigen::Index first_bound() const { return first_limit() + num_limits(); }
    int more() const { return static_cast<int>(first_bound() + num_bounds()) - program_.num_inequalities; }
    /// So that the deviation has a slope where it is zero.
    double floor() const { return 1e-12 * models_[0].scale() * models_[0].scale(); }
    int row_of(Eigen::Index constraint) const {
        const int i = static_cast<int>(constraint);
        return i < program_.num_inequalities ? i : i + more();
    }

    Evaluation values(const VectorXd& y) const {
        const VectorXd z = coordinates_.z(y), step = z - region_.centre;
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
            at.constraints[inequalities + 1] =
                (region_.cut->normal.dot(coordinates_.x(y)) - region_.cut->limit) / region_.radius;
        if (num_limits() > 0)
            at.constraints.segment(first_limit(), num_limits()) =
                (region_.limits.values + region_.limits.slopes * step) / region_.radius;
        if (num_bounds() > 0) at.constraints.segment(first_bound(), num_bounds()) = bounds_.values + bounds_.slopes * y;
        return at;
    }

    void add_slopes(const VectorXd& y, Evaluation& at) const {
        const VectorXd z = coordinates_.z(y), step = z - region_.centre;
        const int inequalities = program_.num_inequalities;
        VectorXd g = models_[0].gradient(z);
        if (deviations_ > 0)
            g -= deviations_ / (2 * std::sqrt(models_[0].variance(z) + floor())) * models_[0].variance_gradient(z);
        at.gradient = coordinates_.slope(g);
        at.jacobian.resize(at.constraints.size(), y.size());
        for (Eigen::Index i = 0; i + 1 < models_.size(); ++i) {
            VectorXd slope = models_[i + 1].gradient(z);
            if (region_.tilt.size() > 0) slope += region_.tilt.row(i).transpose();
            at.jacobian.row(row_of(i)) = coordinates_.slope(slope).transpose();
        }
        at.jacobian.row(inequalities) = coordinates_.slope(step / (region_.radius * region_.radius)).transpose();
        if (region_.cut)
            at.jacobian.row(inequalities + 1) =
                coordinates_.slope_of_variables(region_.cut->normal).transpose() / region_.radius;
        if (num_limits() > 0)
            at.jacobian.middleRows(first_limit(), num_limits()) =
                coordinates_.slopes(region_.limits.slopes) / region_.radius;
        if (num_bounds() > 0) at.jacobian.middleRows(first_bound(), num_bounds()) = bounds_.slopes;
    }

    const NonlinearProgram& program_;
    const LocalModels& models_;
    const ProposalRegion& region_;
    double deviations_;
    const Coordinates& coordinates_;
    StepLimits bounds_;
};

}  // namespace

double ProposalRegion::correction(Eigen::Index row, const VectorXd& z) const {
    return tilt.size() > 0 ? offset[row] + tilt.row(row).dot(z - centre) : offset[row];
}

VectorXd model_minimum(const NonlinearProgram& program, const SampledPoints& points, const LocalModels& models,
                       const ProposalRegion& region, double deviations, const VectorXd& from) {
    MinimizeOptions how;
    how.max_evaluations = max_evaluations;
    how.constraint_tolerance = constraint_tolerance;
    how.confirm = false;
    how.first_step = 0.5 * region.radius;
    how.objective_tolerance = tolerance;
    how.step_tolerance = tolerance * region.radius;
    how.damps_by_secants = !region.is_in_variables;
    how.clock = [] { return 0.0; };
    const auto minimum = [&](const Coordinates& coordinates, const VectorXd& start) {
        const ModelProgram modelled(program, models, region, deviations, coordinates);
        const NonlinearProgram p = modelled.as_program(start);
        Guard inner(p, how);
        Evaluation at;
        if (inner.try_at(p.start, true, at)) minimize_by_sqp(inner);
        how.gained_before += std::max(0.0, at.objective - inner.best.objective);  // so far
        return inner.best_x;
    };
    const bool is_in_variables = region.is_in_variables || models.has_curvature();
    VectorXd z = from;
    std::vector<MetBound> met;  // few bounds are
    for (int round = 0; round < bound_rounds && !is_in_variables; ++round) {
        const KnownDirections directions(program, points, models, region, z, met);
        const VectorXd y = minimum(directions, z);
        z = directions.z(y);
        const std::size_t before = met.size();
        for (const MetBound& bound : directions.beyond(y))
            if (std::ranges::find(met, bound) == met.end()) met.push_back(bound);
        if (met.size() == before) return points.whitened(points.variables(z));
    }
    const FreeVariables variables(program, points);
    return points.whitened(variables.x(minimum(variables, z)));
}

}  // namespace strake
