#include "optimize/evaluate/evaluation.hpp"

#include "core/error.hpp"
#include "optimize/journal/journal.hpp"
#include "optimize/space/parameters.hpp"
#include "optimize/space/response_metric.hpp"
#include "optimize/space/shape_map.hpp"

#include <algorithm>
#include <cmath>

namespace strake {
namespace {

constexpr double gradient_tolerance = 1e-8;  ///< of an adjoint: far below what any method can make use of
constexpr double same_shape = 1e-10;         ///< diagonals, guaranteed at a level's start
constexpr double probe_step = 1e-4;          ///< diagonals: far above round-off, far below an edge
constexpr double probe_tolerance = 1e-6;

bool only_loads(const DesignSpace& space) {
    return std::ranges::all_of(space.variables, [](const Variable& v) {
        return is_load(v.kind) || v.kind == VariableKind::field || v.kind == VariableKind::parameter;
    });
}

std::vector<double> numbers(const std::vector<std::pair<std::string, double>>& named) {
    std::vector<double> all;
    for (const auto& [name, value] : named) all.push_back(value);
    return all;
}

/// " at area = 3, alpha = 0.1": what a formula is computed from. @param names of `values`
std::string inputs_words(const Combination& formula, const std::vector<std::string>& names,
                         const std::vector<double>& values, const std::vector<ProgramParameter>& parameters,
                         const std::vector<double>& parameter_values) {
    std::string words;
    for (const std::string& name : formula.of) {
        const auto value = std::ranges::find(names, name);
        const auto own = std::ranges::find(parameters, name, &ProgramParameter::name);
        const double number = value != names.end()
                                  ? values.at(static_cast<std::size_t>(value - names.begin()))
                                  : parameter_values.at(static_cast<std::size_t>(own - parameters.begin()));
        words += text(words.empty() ? " at " : ", ", name, " = ", number);
    }
    return words;
}

}  // namespace

ShapeEvaluator::ShapeEvaluator(const Problem& problem, std::shared_ptr<const RestFacts> rest,
                               const std::vector<std::string>& differentiated)
    : problem_(problem),
      rest_(std::move(rest)),
      solver_(problem, rest_),
      calls_(problem, rest_, differentiated),
      queue_(problem.quantities, [this](const Eigen::VectorXd& x, int number) { return begin(x, number); }) {}

void ShapeEvaluator::keep_calls(Journal* journal, const std::function<bool()>& stop_wanted, bool forgets_dropped) {
    journal_ = journal;
    stop_wanted_ = stop_wanted;
    solver_.set_stop(stop_wanted);
    calls_.keep_calls(journal, stop_wanted);
    queue_.keep_calls(forgets_dropped ? journal : nullptr, stop_wanted);
}

void ShapeEvaluator::enter(const DesignSpace& space) {
    solver_.enter(space);
    inside_x_.resize(0);
    enters_ = true;
}

void ShapeEvaluator::set_ranges(const DesignSpace& space) { solver_.set_ranges(space.lower, space.upper); }

void ShapeEvaluator::limit_motion() {
    std::optional<Poses> poses;
    try {
        MotionLimit limit = strake::motion_limit(problem_, rest_, stop_wanted_, poses);
        solver_.set_limit(std::move(limit), std::move(poses));
    } catch (const SolverError& error) {
        solver_.refuse_all(text("the surface under the given loads and strains alone: ", error.what()));
    }
}

Eigen::VectorXd ShapeEvaluator::within(const Eigen::VectorXd& x, double slack, double angle) {
    return moved_inside(solver_, x, inside_x_, slack, angle);
}

bool ShapeEvaluator::has_shape(const Eigen::VectorXd& x) {
    try {
        return solver_.has_shape(x);
    } catch (const Interrupted&) {
        queue_.interrupt();
    }
}

std::string ShapeEvaluator::refusal(const Eigen::VectorXd& x) {
    try {
        return solver_.refusal(x);
    } catch (const Interrupted&) {
        queue_.interrupt();
    }
}

bool ShapeEvaluator::is_beyond(const Eigen::VectorXd& x, double slack) {
    ShapeEvaluation shape;
    return !solver_.limit().is_none() && solver_.settle(x, shape) &&
           (!is_inside(solver_, shape.vertices, slack, EdgeFolds::kept) || is_folded(space(), x));
}

FoldConditions ShapeEvaluator::fold_conditions(const Eigen::VectorXd& x, double below) const {
    return solver_.limit().is_none() ? FoldConditions() : strake::fold_conditions(space(), x, below);
}

FoldConditions ShapeEvaluator::fold_conditions_between(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    return solver_.limit().is_none() ? FoldConditions() : strake::fold_conditions_between(space(), from, to);
}

MotionConditions ShapeEvaluator::motion_conditions(const Eigen::VectorXd& x, double min_used,
                                                   const EdgeFolds::Angles& angles) {
    return strake::motion_conditions(solver_, x, min_used, angles);
}

void ShapeEvaluator::accept() {
    if (solver_.last()) accepted_measured_ = last_measured_;
    solver_.accept();
}

bool ShapeEvaluator::deform(const Eigen::VectorXd& x, ShapeEvaluation& result) {
    try {
        return solver_.deform(x, result);
    } catch (const Interrupted&) {
        queue_.interrupt();
    }
}

/// A level begins with the shape that the level before ended with: nobody pays for its values twice.
bool ShapeEvaluator::take_over(const Eigen::VectorXd& x, ShapeEvaluation& result) const {
    const Measured& m = accepted_measured_;
    if (!m.facts || m.facts->surface.vertices.rows() != result.vertices.rows() ||
        m.parameters != x.tail(space().num_parameters()))
        return false;
    if ((m.facts->surface.vertices - result.vertices).rowwise().norm().maxCoeff() > same_shape * rest_->diagonal)
        return false;
    result.values = m.values;
    result.dJ_dv = m.dJ_dv;
    result.dJ_dp = m.dJ_dp;
    result.has_gradients_to_come = m.has_gradients_to_come;
    result.status = EvaluationStatus::ok;
    result.is_taken_over = true;
    return true;
}

Points ShapeEvaluator::begin_from(const Poses& poses, const Eigen::VectorXd& x, std::string& reason) {
    ShapeEvaluation shape;
    if (solver_.begin_from(poses, x, shape)) accepted_measured_ = last_measured_;
    reason = shape.reason;
    return shape.vertices;
}

/// Deforms, and lays out what is to be asked; in parallel the queue starts the programs.
QueuedDesign ShapeEvaluator::begin(const Eigen::VectorXd& x, int number) {
    QueuedDesign design;
    design.number = number;
    design.x = x;
    const bool begins = std::exchange(enters_, false);
    try {
        if (!solver_.deform(x, design.result)) return design;
    } catch (const Interrupted&) {  // ends the run, not this design
        throw;
    } catch (...) {
        design.thrown = std::current_exception();
        return design;
    }
    design.poses = solver_.last();
    if (!(takes_over_ && begins && take_over(x, design.result))) {
        const auto facts = calls_.facts_of(space(), x, number, design.result.vertices);
        if (journal_) design.result.surface = facts->hash;
        design.calls = calls_.value_calls(facts);
    }
    return design;
}

Points ShapeEvaluator::equilibrium(const Eigen::VectorXd& x) {
    ShapeEvaluation shape;
    solver_.settle(x, shape);
    return std::move(shape.vertices);
}

ShapeEvaluation ShapeEvaluator::evaluate(const Eigen::VectorXd& x, int number) {
    QueuedDesign design = queue_.next(x, number);
    ShapeEvaluation& result = design.result;
    solver_.set_last(std::move(design.poses), x);
    if (result.is_taken_over) last_measured_ = accepted_measured_;
    if (design.calls) measure(design);
    if (result.status == EvaluationStatus::ok) inside_x_ = x;  // others are no place to move designs to
    // Such a failure ends the run: nobody asks for what was begun beside it.
    if (result.status == EvaluationStatus::quantity_failed && !result.may_go_on) queue_.clear();
    return std::move(result);
}

void ShapeEvaluator::differentiate(ShapeEvaluation& evaluation) {
    if (evaluation.status != EvaluationStatus::ok || !solver_.last())
        throw InvalidInput("differentiate: the last evaluation gave no shape");
    if (evaluation.has_gradients_to_come && !ask_for_gradients(evaluation)) return;
    if (ShapeEvaluation again; !solver_.is_at(solver_.last_x()))
        if (!deform(Eigen::VectorXd(solver_.last_x()), again))
            throw SolverError("a shape that was reached is not reached again");
    const auto& kinds = rest_->parameters.kinds;
    AdjointOptions options;
    options.tolerance = gradient_tolerance;
    options.prism_height = space().changes_height() || std::ranges::count(kinds, VariableKind::stiffness) > 0;
    try {
        evaluation.sensitivities = solver_.adjoint(evaluation.dJ_dv, options, evaluation.vertices);
    } catch (const SolverError& error) {  // an equilibrium on the brink of buckling
        evaluation.status = EvaluationStatus::unstable;
        evaluation.reason = error.what();
        return;
    }
    const auto& all = evaluation.sensitivities;
    evaluation.gradients.resize(static_cast<Eigen::Index>(all.size()), space().size());
    for (std::size_t i = 0; i < all.size(); ++i)
        evaluation.gradients.row(static_cast<Eigen::Index>(i)) = design_gradient(space(), solver_.last_x(), all[i]);
    if (!evaluation.gradients.allFinite()) throw SolverError("the adjoint gave a gradient that is not finite");
    for (std::size_t i = 0; i < all.size(); ++i)
        evaluation.gradients.row(static_cast<Eigen::Index>(i)).tail(space().num_parameters()) =
            evaluation.dJ_dp[i].cwiseProduct(parameter_units(space())).transpose();
}

Eigen::VectorXd ShapeEvaluator::metric_product(const Eigen::VectorXd& x, const Eigen::VectorXd& d) {
    if (!only_loads(space())) return {};
    ShapeEvaluation here;
    if (!(solver_.last() && solver_.last_x() == x && solver_.is_at(x)) && !deform(x, here)) return {};
    if (!solver_.settle(x, here)) return {};
    try {
        // Sections are kept as at rest, where loads and motions know them: the product stays symmetric.
        return present_product(space(), shell(), d, rest_->parameters.kept_sections ? nullptr : &here.vertices);
    } catch (const SolverError&) {
        return {};
    }
}

std::optional<double> ShapeEvaluator::curvature_along(const Eigen::VectorXd& x, const DesignSpace& finer,
                                                      const Eigen::VectorXd& step, const Eigen::VectorXd& weight) {
    ShapeEvaluation shape;
    if (!only_loads(finer) || !only_loads(space()) || finer.num_parameters() > 0 || !deform(x, shape)) return {};
    Points moved;
    try {
        const Points about = solver_.beside_planform(shape.vertices);
        moved = surface_response(*rest_, shell(), {load_forces(finer, step)}, probe_tolerance, &about)[0] +
                field_motion(finer, step, &about);
    } catch (const SolverError&) {
        return {};
    }
    const double size = std::sqrt(moved.rowwise().squaredNorm().maxCoeff());
    if (!(size > 0)) return {};
    const double h = probe_step * rest_->diagonal / size;
    const auto here = calls_.slopes_along(shape.vertices, moved, space().level);
    const auto there = calls_.slopes_along(shape.vertices + h * moved, moved, space().level);
    if (!here || !there) return {};
    const double curvature = weight.dot(*there - *here) / h;
    return std::isfinite(curvature) ? std::optional(curvature) : std::nullopt;
}

/// The value of a combination; where it is not finite (a formula's logarithm of a negative number) the step is too far.
bool ShapeEvaluator::combine(const Quantity& quantity, const std::vector<double>& parameters, ShapeEvaluation& result) {
    Measured& m = last_measured_;
    const int place = static_cast<int>(m.values.size());
    const double value = calls_.combinations().value(place, m.values, parameters);
    if (!std::isfinite(value)) {
        result.status = EvaluationStatus::quantity_failed;
        result.may_go_on = true;
        result.reason =
            text(quantity.names[0], ": undefined: the formula gives ", std::isnan(value) ? "nan" : text(value),
                 inputs_words(*quantity.combination, names(), m.values, problem_.program_parameters, parameters));
        return false;
    }
    m.values.push_back(value);
    m.known_dJ_dv.emplace_back();
    m.known_dJ_dp.emplace_back();
    return true;
}

void ShapeEvaluator::measure(QueuedDesign& design) {
    ShapeEvaluation& result = design.result;
    Measured& m = last_measured_;
    m = {};
    m.parameters = design.x.tail(space().num_parameters());
    const std::vector<double> parameters = numbers(design.calls->facts()->parameters);
    for (std::size_t q = 0; q < problem_.quantities.size(); ++q) {
        if (problem_.quantities[q].combination) {
            if (!combine(problem_.quantities[q], parameters, result)) return;
            continue;
        }
        m.has_gradients_to_come |= calls_.are_gradients_apart(q);
        QuantityResult measured = calls_.take(*design.calls, q, true, result);
        if (measured.failure) return;
        m.values.insert(m.values.end(), measured.values.begin(), measured.values.end());
        m.known_dJ_dv.insert(m.known_dJ_dv.end(), measured.dJ_dv.begin(), measured.dJ_dv.end());
        m.known_dJ_dp.insert(m.known_dJ_dp.end(), measured.dJ_dp.begin(), measured.dJ_dp.end());
    }
    m.facts = design.calls->facts();
    result.values = m.values;
    result.has_gradients_to_come = m.has_gradients_to_come;
    if (m.has_gradients_to_come || take_gradients(result)) result.status = EvaluationStatus::ok;
}

/// Of the shape whose values the last evaluation gave, maybe that of an earlier one.
bool ShapeEvaluator::ask_for_gradients(ShapeEvaluation& result) {
    Measured& m = last_measured_;
    queue_.drop_expected(m.facts->number + 1);
    QueuedDesign design;
    design.calls = calls_.gradient_calls(m.facts);
    design = queue_.finish(std::move(design));
    int first = 0;
    for (std::size_t q = 0; q < problem_.quantities.size(); ++q) {
        const int count = static_cast<int>(problem_.quantities[q].names.size());
        if (calls_.are_gradients_apart(q)) {
            QuantityResult found = calls_.take(*design.calls, q, false, result);
            if (found.failure) return false;
            std::move(found.dJ_dv.begin(), found.dJ_dv.end(), m.known_dJ_dv.begin() + first);
            std::move(found.dJ_dp.begin(), found.dJ_dp.end(), m.known_dJ_dp.begin() + first);
        }
        first += count;
    }
    if (!take_gradients(result)) return false;
    if (accepted_measured_.facts == m.facts) accepted_measured_ = m;
    return true;
}

/// Those of the differentiated values, checked, from what the quantities gave.
bool ShapeEvaluator::take_gradients(ShapeEvaluation& result) {
    Measured& m = last_measured_;
    const int n = rest_->surface.num_vertices();
    calls_.combinations().differentiate(calls_.needed(), m.values, numbers(m.facts->parameters), m.known_dJ_dv,
                                        m.known_dJ_dp);
    for (const int i : calls_.differentiated()) {
        if (m.known_dJ_dv[i].rows() != n || !m.known_dJ_dv[i].allFinite()) {
            result.status = EvaluationStatus::quantity_failed;
            result.may_go_on = false;
            result.reason = text(names()[i], ": no finite vertex sensitivities (", m.known_dJ_dv[i].rows(),
                                 " rows for ", n, " vertices); a gradient-free method (cobyla) can do without");
            return false;
        }
        if (!parameter_derivatives_usable(i, m.known_dJ_dp[i], result)) return false;
        m.dJ_dv.push_back(std::move(m.known_dJ_dv[i]));
        m.dJ_dp.push_back(std::move(m.known_dJ_dp[i]));
    }
    m.known_dJ_dv.clear();
    m.known_dJ_dp.clear();
    m.has_gradients_to_come = false;
    result.dJ_dv = m.dJ_dv;
    result.dJ_dp = m.dJ_dp;
    result.has_gradients_to_come = false;
    return true;
}

/// None given: the value depends on the shape alone. Not known ones are left to differences where these are allowed.
bool ShapeEvaluator::parameter_derivatives_usable(int i, Eigen::VectorXd& dJ_dp, ShapeEvaluation& result) const {
    const int count = space().num_parameters();
    if (dJ_dp.size() == 0) dJ_dp = Eigen::VectorXd::Zero(count);
    std::string what;
    if (dJ_dp.size() != count) what = text(dJ_dp.size(), " derivatives for ", count, " variables of the case");
    for (int j = 0; j < count && what.empty(); ++j)
        if (std::isinf(dJ_dp[j]) || (std::isnan(dJ_dp[j]) && !problem_.optimize.finite_differences))
            what = text("no finite derivative by ", rest_->program_parameters[j].name);
    if (what.empty()) return true;
    result.status = EvaluationStatus::quantity_failed;
    result.may_go_on = false;
    result.reason = text(names()[i], ": ", what, "; optimize.finite_differences or a gradient-free method (cobyla) ",
                         "can do without");
    return false;
}

}  // namespace strake
