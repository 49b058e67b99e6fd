#include "optimize/evaluate/limited_motion.hpp"

#include "core/error.hpp"
#include "core/fields/displacement_fields.hpp"
#include "optimize/evaluate/fold_conditions.hpp"
#include "optimize/nlp/model/quadratic_model.hpp"
#include "optimize/space/shape_map.hpp"

#include <numbers>

namespace strake {
namespace {

constexpr int max_conditions = 24, max_folds = 12;
constexpr int max_steps = 6;                     ///< onto the conditions: each is exact to second order
constexpr int max_bisections = 8;                ///< of the way back: leaves 1/256 of it
constexpr double nearly_beyond = 0.97;           ///< of its limit: a step may take a vertex beyond that was not
constexpr double nearly_folded = 0.2;            ///< determinant: the same of triangles
constexpr EdgeFolds::Angles below_kept{-8, -1};  ///< degrees: the same of edges, and what is aimed at
constexpr double border_aim = EdgeFolds::Angles{}.aimed;
constexpr double moved_angle = -0.1;  ///< below what they keep: of designs that are moved
constexpr double degree = std::numbers::pi / 180;
constexpr double adjoint_tolerance = 1e-11;  ///< that units and rounding choose no other designs

bool is_moved(const RigidMotion& motion) { return !motion.rotation.isZero(0) || !motion.translation.isZero(0); }

/// The pins of strain cores at zero are part of the datum: they hold the shell from the first level on.
std::vector<int> pins_of(const Problem& problem, const std::shared_ptr<const RestFacts>& rest) {
    const auto& kinds = problem.parameters.kinds;
    if (std::find(kinds.begin(), kinds.end(), VariableKind::strain) == kinds.end()) return rest->setup.options.pin;
    return design_space(rest, rest->tree->levels.size() > 1 ? 1 : 0).pin;
}

/// The equilibrium at x is that of the shell: set again where another was sought in between.
bool settle(ShapeSolver& solver, const Eigen::VectorXd& x, Points& vertices) {
    ShapeEvaluation shape;
    if (!solver.settle(x, shape)) return false;
    vertices = std::move(shape.vertices);
    return true;
}

bool is_inside(const ShapeSolver& solver, const Eigen::VectorXd& x, const Points& vertices, double slack,
               double determinant, double angle) {
    return is_inside(solver, vertices, slack, angle) && !is_folded(solver.space(), x, determinant);
}

/// The shortest step in the metric that keeps `slack` of the limits; empty: none was found.
Eigen::VectorXd step_inside(const ShapeSolver& solver, const Eigen::VectorXd& x, const MotionConditions& at,
                            const FoldConditions& folds, double slack) {
    const DesignSpace& space = solver.space();
    QuadraticModel m;
    m.gradient = Eigen::VectorXd::Zero(x.size());
    m.hessian = space.metric;
    m.lower = space.lower - x;
    m.upper = space.upper - x;
    for (int j = 0; j < space.num_shape(); ++j)  // these move the datum, too
        if (space.variables[static_cast<std::size_t>(j)].kind == VariableKind::planform) m.lower[j] = m.upper[j] = 0;
    m.jacobian.resize(0, x.size());
    StepLimits limits{at.values, at.slopes};
    for (std::size_t i = 0; i < at.rows.size(); ++i)
        limits.values[static_cast<Eigen::Index>(i)] += slack * at.rows[i].limit / solver.limit().reference();
    m.add_inequalities(limits);
    m.add_inequalities({folds.values, folds.slopes});
    return solve_model(m);
}

Eigen::VectorXd on_the_way_back(ShapeSolver& solver, const Eigen::VectorXd& x, const Eigen::VectorXd& inside,
                                double slack, double angle) {
    if (inside.size() != x.size()) return x;
    double low = 0, high = 1;
    for (int k = 0; k < max_bisections; ++k) {
        const double middle = 0.5 * (low + high);
        Points vertices;
        const Eigen::VectorXd there = inside + middle * (x - inside);
        const bool is_within = settle(solver, there, vertices) &&
                               is_inside(solver, there, vertices, slack, moved_determinant, angle + moved_angle);
        (is_within ? low : high) = middle;
    }
    return low > 0 ? Eigen::VectorXd(inside + low * (x - inside)) : inside;
}

/// Derivatives of rows, and of a border's, where each is that of one vertex and nothing else.
void differentiate_rows(ShapeSolver& solver, const Eigen::VectorXd& x, const AdjointOptions& options,
                        MotionConditions& at) {
    const DesignSpace& space = solver.space();
    const auto& fields = space.rest->parameters.fields;
    std::vector<int> moved;
    Points directions(at.values.size(), 3);
    for (std::size_t i = 0; i < at.rows.size(); ++i) {
        moved.push_back(at.rows[i].vertex);
        directions.row(static_cast<Eigen::Index>(i)) = at.rows[i].direction / solver.limit().reference();
    }
    for (const EdgeFolds::Row& border : at.folds) {
        directions.row(static_cast<Eigen::Index>(moved.size())) = degree * border.gradient.row(3);
        moved.push_back(border.vertices[3]);
    }
    at.sensitivities = solver.adjoint_of_vertices(moved, directions, options);
    for (Eigen::Index i = 0; i < at.values.size(); ++i) {
        Eigen::VectorXd slope = design_gradient(space, x, at.sensitivities[static_cast<std::size_t>(i)]);
        if (fields)
            slope += design_gradient_of_fields(
                space, fields->gradient(moved[static_cast<std::size_t>(i)], directions.row(i).transpose()));
        at.slopes.row(i) = slope;
    }
}

void differentiate(ShapeSolver& solver, const Eigen::VectorXd& x, const Points& vertices, const AdjointOptions& options,
                   MotionConditions& at) {
    at.slopes.resize(at.values.size(), x.size());
    if (std::ranges::all_of(at.folds, &EdgeFolds::Row::is_border) && acts_as_given(*solver.space().rest))
        return differentiate_rows(solver, x, options, at);
    std::vector<Points> functionals(at.rows.size() + at.folds.size(), Points::Zero(vertices.rows(), 3));
    for (std::size_t i = 0; i < at.rows.size(); ++i)
        functionals[i].row(at.rows[i].vertex) = at.rows[i].direction / solver.limit().reference();
    for (std::size_t i = 0; i < at.folds.size(); ++i)
        for (int k = 0; k < 4; ++k)
            functionals[at.rows.size() + i].row(at.folds[i].vertices[static_cast<std::size_t>(k)]) =
                degree * at.folds[i].gradient.row(k);
    at.sensitivities = solver.adjoint(functionals, options, vertices);
    for (Eigen::Index i = 0; i < at.values.size(); ++i)
        at.slopes.row(i) = design_gradient(solver.space(), x, at.sensitivities[static_cast<std::size_t>(i)]);
}

}  // namespace

MotionLimit motion_limit(const Problem& problem, const std::shared_ptr<const RestFacts>& rest,
                         const std::function<bool()>& stop_wanted, std::optional<Poses>& poses) {
    if (!limits_motion(rest->parameters)) return {};
    const ShellSetup& setup = rest->setup;
    const bool is_loaded = setup.loads.force.rows() > 0 && !setup.loads.force.isZero(0);
    if (!is_loaded && std::none_of(setup.motions.begin(), setup.motions.end(), is_moved))
        return {*rest, rest->surface.vertices};
    ShellOptions options = setup.options;
    options.pin = pins_of(problem, rest);
    std::vector<RigidMotion> motions = setup.motions;
    const int last = *std::max_element(options.pin.begin(), options.pin.end());
    motions.resize(static_cast<std::size_t>(std::max(last, static_cast<int>(motions.size()))));
    const Points& start = rest->elastic().vertices;
    PrimoShell shell(rest->elastic(), options);
    Loads loads = setup.loads;
    if (is_loaded && rest->parameters.kept_sections) loads.force = kept_forces(*rest, loads.force);
    const Equilibrium end =
        shell.solve(loads, motions, {}, [&](const SolveRecord&) { return !(stop_wanted && stop_wanted()); });
    if (end.status == SolveStatus::cancelled) throw Interrupted{};
    if (end.status != SolveStatus::converged) throw SolverError(end.reason);
    poses = shell.poses();
    return {*rest, Points(rest->surface.vertices + kept_motion(*rest, carried(*rest, shell.vertices() - start)))};
}

bool is_inside(const ShapeSolver& solver, const Points& vertices, double slack, double angle) {
    return solver.limit().is_within(solver.beside_planform(vertices), slack) &&
           !solver.edge_folds().any_above(angle, vertices);
}

MotionConditions motion_conditions(ShapeSolver& solver, const Eigen::VectorXd& x, double min_used,
                                   const EdgeFolds::Angles& angles) {
    MotionConditions at;
    Points vertices;
    if (solver.limit().is_none() || !settle(solver, x, vertices)) return at;
    at.rows = solver.limit().rows(solver.beside_planform(vertices), min_used, max_conditions);
    at.folds = solver.edge_folds().rows(vertices, angles.nearly, max_folds);
    if (at.rows.empty() && at.folds.empty()) return at;
    at.values.resize(static_cast<Eigen::Index>(at.rows.size() + at.folds.size()));
    const double unit = solver.limit().reference();
    for (std::size_t i = 0; i < at.rows.size(); ++i) at.values[static_cast<Eigen::Index>(i)] = at.rows[i].value / unit;
    for (std::size_t i = 0; i < at.folds.size(); ++i)
        at.values[at.num_rows() + static_cast<Eigen::Index>(i)] =
            degree * (at.folds[i].angle - (at.folds[i].is_border ? std::min(angles.aimed, border_aim) : angles.aimed));
    AdjointOptions options;
    options.tolerance = adjoint_tolerance;
    const DesignSpace& space = solver.space();
    options.prism_height =
        space.changes_height() || std::ranges::count(space.rest->parameters.kinds, VariableKind::stiffness) > 0;
    try {
        differentiate(solver, x, vertices, options, at);
    } catch (const SolverError&) {  // on the brink of buckling nothing is known of steps
        return {};
    }
    for (int j = 0; j < space.num_shape(); ++j)  // the datum goes with the planform
        if (space.variables[static_cast<std::size_t>(j)].kind == VariableKind::planform)
            at.slopes.col(j).head(at.num_rows()).setZero();
    if (!at.slopes.allFinite()) return {};
    return at;
}

MotionConditions on_steps(MotionConditions at, const Eigen::VectorXd& way) {
    if (at.values.size() == 0) return at;
    if (way.size() > 0) at.values -= at.slopes * way;  // distances are convex: what is within is not cut off
    const double length = way.squaredNorm();
    for (Eigen::Index i = at.num_rows(); i < at.values.size(); ++i) {
        if (!(at.values[i] > 0)) continue;
        if (length > 0) at.slopes.row(i) += at.values[i] / length * way.transpose();
        at.values[i] = 0;
    }
    return at;
}

Eigen::VectorXd moved_inside(ShapeSolver& solver, const Eigen::VectorXd& asked, const Eigen::VectorXd& inside,
                             double slack, double angle) {
    if (solver.limit().is_none()) return asked;
    Eigen::VectorXd x = asked;
    Points vertices;
    if (!settle(solver, x, vertices) || is_inside(solver, x, vertices, slack, kept_determinant, angle)) return asked;
    const DesignSpace& space = solver.space();
    for (int k = 0; k < max_steps; ++k) {
        const MotionConditions at =
            motion_conditions(solver, x, nearly_beyond, {angle + below_kept.nearly, angle + below_kept.aimed});
        const FoldConditions folds = fold_conditions(space, x, nearly_folded);
        if (at.values.size() + folds.values.size() == 0) break;
        const Eigen::VectorXd step = step_inside(solver, x, at, folds, 2 * slack);
        if (step.size() == 0 || !step.allFinite()) break;
        x = (x + step).cwiseMax(space.lower).cwiseMin(space.upper);
        if (!settle(solver, x, vertices)) break;
        if (is_inside(solver, x, vertices, slack, moved_determinant, angle + moved_angle)) return x;
    }
    return on_the_way_back(solver, x, inside, slack, angle);
}

}  // namespace strake
