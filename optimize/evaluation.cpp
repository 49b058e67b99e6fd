#include "optimize/evaluation.hpp"

#include "core/error.hpp"
#include "optimize/own_variables.hpp"

namespace strake {
namespace {

/// A reasonable step takes four to eight; more than these are better spent on a shorter step.
constexpr int max_iterations = 14;
constexpr double gradient_tolerance = 1e-8;  ///< of an adjoint: far below what any method can make use of
constexpr double same_shape = 1e-10;         ///< diagonals, as is promised of a level's start
constexpr std::size_t known_shapes = 3;      ///< equilibria of a level from which the nearest is the start of the next
constexpr double probe_step = 1e-4;          ///< diagonals: far above round-off, far below an edge
constexpr double probe_tolerance = 1e-6;

bool only_loads(const DesignSpace& space) {
    return std::ranges::all_of(space.variables,
                               [](const Variable& v) { return is_load(v.kind) || v.kind == VariableKind::own; });
}

std::vector<std::string> value_names(const Problem& problem) {
    std::vector<std::string> names;
    for (const Quantity& quantity : problem.quantities)
        for (const std::string& name : quantity.names) {
            if (std::find(names.begin(), names.end(), name) != names.end())
                throw InvalidInput(text("two quantities are called '", name, "'"));
            names.push_back(name);
        }
    return names;
}

}  // namespace

std::string to_string(EvaluationStatus status) {
    switch (status) {
        case EvaluationStatus::ok:
            return "ok";
        case EvaluationStatus::not_converged:
            return "not_converged";
        case EvaluationStatus::unstable:
            return "unstable";
        case EvaluationStatus::invalid:
            return "invalid";
        case EvaluationStatus::quantity_failed:
            return "quantity_failed";
    }
    return "unknown";
}

ShapeEvaluator::ShapeEvaluator(const Problem& problem, std::shared_ptr<const RestFacts> rest,
                               const std::vector<std::string>& differentiated)
    : problem_(problem),
      rest_(std::move(rest)),
      guard_(rest_->surface, rest_->adjacent, {problem.fixed, problem.symmetry, attached_triangles(problem)}),
      names_(value_names(problem)),
      combinations_(problem.quantities, problem.own) {
    for (const std::string& name : differentiated) differentiated_.push_back(index_of(name));
    needed_ = combinations_.with_parts(differentiated_);
    set_gradient_calls();
    for (const Quantity& quantity : problem.quantities)
        if (!quantity.program.empty()) parallel_ = std::max(parallel_, quantity.parallel);
}

int ShapeEvaluator::index_of(const std::string& name) const {
    const auto at = std::find(names_.begin(), names_.end(), name);
    if (at != names_.end()) return static_cast<int>(at - names_.begin());
    std::string known;
    for (const std::string& other : names_) known += (known.empty() ? "" : ", ") + other;
    throw InvalidInput(text("no quantity is called '", name, "'; there are: ", known));
}

void ShapeEvaluator::enter(const DesignSpace& space) {
    space_ = space;
    last_.reset();
    known_.clear();
    enters_ = true;
}

const Poses* ShapeEvaluator::nearest_known(const Eigen::VectorXd& x) const {
    const Poses* nearest = accepted_ ? &*accepted_ : nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const KnownShape& shape : known_) {
        const Eigen::VectorXd d = x - shape.x;
        const double distance = d.dot(space_.metric * d);
        if (distance < least) least = distance, nearest = &shape.poses;
    }
    return nearest;
}

void ShapeEvaluator::accept() {
    if (last_) accepted_ = last_;
    if (last_) accepted_measured_ = last_measured_;
}

/// A level begins with the shape that the level before ended with: nobody pays for its values twice.
bool ShapeEvaluator::take_over(const Eigen::VectorXd& x, ShapeEvaluation& result) const {
    const Measured& m = accepted_measured_;
    if (!m.facts || m.facts->surface.vertices.rows() != result.vertices.rows() || m.own != x.tail(space_.num_own()))
        return false;
    if ((m.facts->surface.vertices - result.vertices).rowwise().norm().maxCoeff() > same_shape * rest_->diagonal)
        return false;
    result.values = m.values;
    result.dJ_dv = m.dJ_dv;
    result.dJ_down = m.dJ_down;
    result.has_gradients_to_come = m.has_gradients_to_come;
    result.status = EvaluationStatus::ok;
    result.is_taken_over = true;
    return true;
}

/// A shell serves as long as pins and heights stay; loads and motions change freely.
void ShapeEvaluator::build_shell(const ShellDemand& demand) {
    if (shell_ && shell_pin_ == space_.pin && shell_height_ == demand.prism_height) return;
    ShellOptions options = rest_->setup.options;
    options.pin = space_.pin;
    options.prism_height = demand.prism_height;
    shell_.reset();  // before the new one: two factors may not fit
    shell_ = std::make_unique<PrimoShell>(rest_->surface, options);
    shell_pin_ = space_.pin;
    shell_height_ = demand.prism_height;
}

bool ShapeEvaluator::deform(const Eigen::VectorXd& x, ShapeEvaluation& result) {
    const ShellDemand wanted = demand(space_, x);
    build_shell(wanted);
    const Poses* start = nearest_known(x);
    if (start) shell_->set_poses(*start);
    SolveOptions options;
    options.keep_factor = true;
    // From an accepted design on a shorter step is cheaper than a way around a buckling point; the first design has to
    // be reached as it is.
    if (start) options.max_iterations = max_iterations;
    options.fallbacks = !start;
    last_.reset();
    shell_x_.resize(0);
    Equilibrium end;
    try {
        end = shell_->solve(wanted.loads, wanted.motions, options,
                            [this](const SolveRecord&) { return !(stop_wanted_ && stop_wanted_()); });
    } catch (const SolverError& error) {
        end.reason = error.what();
        shell_.reset();  // where it stopped is no place to go on from
    }
    if (end.status == SolveStatus::cancelled) interrupt();
    if (end.status != SolveStatus::converged) {
        result.status =
            end.status == SolveStatus::unstable ? EvaluationStatus::unstable : EvaluationStatus::not_converged;
        result.reason = end.reason;
        return false;
    }
    last_ = shell_->poses();
    last_x_ = shell_x_ = x;
    const Points vertices = shell_->vertices();
    result.reason = guard_.defect(vertices, *last_);
    if (!result.reason.empty()) {
        result.status = EvaluationStatus::invalid;
        last_.reset();
        return false;
    }
    std::erase_if(known_, [&](const KnownShape& shape) { return shape.x == x; });
    if (known_.size() == known_shapes) known_.erase(known_.begin());
    known_.push_back({x, *last_});
    result.vertices = vertices;
    result.max_displacement = std::sqrt((vertices - rest_->surface.vertices).rowwise().squaredNorm().maxCoeff());
    return true;
}

Points ShapeEvaluator::begin_from(const Poses& poses, const Eigen::VectorXd& x, std::string& reason) {
    accepted_ = poses;
    ShapeEvaluation shape;
    if (deform(x, shape)) accept();
    reason = shape.reason;
    return shape.vertices;
}

ShapeEvaluation ShapeEvaluator::evaluate(const Eigen::VectorXd& x, int number) {
    Design design = next(x, number);
    ShapeEvaluation& result = design.result;
    last_ = std::move(design.poses);
    last_x_ = x;
    if (result.is_taken_over) last_measured_ = accepted_measured_;
    if (design.calls) measure(design);
    // Such a failure ends the run: nobody asks for what was begun beside it.
    if (result.status == EvaluationStatus::quantity_failed && !result.may_go_on) give_up();
    return std::move(result);
}

void ShapeEvaluator::differentiate(ShapeEvaluation& evaluation) {
    if (evaluation.status != EvaluationStatus::ok || !last_)
        throw InvalidInput("differentiate: the last evaluation gave no shape");
    if (evaluation.has_gradients_to_come && !ask_for_gradients(evaluation)) return;
    if (ShapeEvaluation again; shell_x_.size() != last_x_.size() || shell_x_ != last_x_)
        if (!deform(last_x_, again)) throw SolverError("a shape that was reached is not reached again");
    const auto& kinds = rest_->parameters.kinds;
    AdjointOptions options;
    options.tolerance = gradient_tolerance;
    options.prism_height = space_.changes_height() || std::ranges::count(kinds, VariableKind::stiffness) > 0;
    try {
        evaluation.sensitivities = shell_->adjoint(evaluation.dJ_dv, options);
    } catch (const SolverError& error) {  // an equilibrium on the brink of buckling
        evaluation.status = EvaluationStatus::unstable;
        evaluation.reason = error.what();
        return;
    }
    const auto& all = evaluation.sensitivities;
    evaluation.gradients.resize(static_cast<Eigen::Index>(all.size()), space_.size());
    for (std::size_t i = 0; i < all.size(); ++i)
        evaluation.gradients.row(static_cast<Eigen::Index>(i)) = design_gradient(space_, last_x_, all[i]);
    if (!evaluation.gradients.allFinite()) throw SolverError("the adjoint gave a gradient that is not finite");
    for (std::size_t i = 0; i < all.size(); ++i)
        evaluation.gradients.row(static_cast<Eigen::Index>(i)).tail(space_.num_own()) =
            evaluation.dJ_down[i].cwiseProduct(own_units(space_)).transpose();
}

Eigen::VectorXd ShapeEvaluator::metric_product(const Eigen::VectorXd& x, const Eigen::VectorXd& d) {
    if (!only_loads(space_)) return {};
    ShapeEvaluation unused;
    if (!(last_ && last_x_ == x && shell_x_ == x) && !deform(x, unused)) return {};
    try {
        return present_product(space_, *shell_, d);
    } catch (const SolverError&) {
        return {};
    }
}

std::optional<double> ShapeEvaluator::curvature_along(const Eigen::VectorXd& x, const DesignSpace& finer,
                                                      const Eigen::VectorXd& step, const Eigen::VectorXd& weight) {
    ShapeEvaluation shape;
    if (!only_loads(finer) || !only_loads(space_) || finer.num_own() > 0 || !deform(x, shape)) return {};
    Points moved;
    try {
        moved = shell_->response({load_forces(finer, step)}, probe_tolerance)[0];
    } catch (const SolverError&) {
        return {};
    }
    const double size = std::sqrt(moved.rowwise().squaredNorm().maxCoeff());
    if (!(size > 0)) return {};
    const double h = probe_step * rest_->diagonal / size;
    const auto here = slopes_along(shape.vertices, moved), there = slopes_along(shape.vertices + h * moved, moved);
    if (!here || !there) return {};
    const double curvature = weight.dot(*there - *here) / h;
    return std::isfinite(curvature) ? std::optional(curvature) : std::nullopt;
}

}  // namespace strake
