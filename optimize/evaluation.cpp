#include "optimize/evaluation.hpp"

#include "core/error.hpp"
#include "optimize/journal.hpp"
#include "optimize/own_variables.hpp"

#include <chrono>

namespace strake {
namespace {

/// A reasonable step takes four to six; more than nine are better spent on a shorter step.
constexpr int max_iterations = 9;
constexpr double same_shape = 1e-10;     ///< diagonals, as is promised of a level's start
constexpr std::size_t known_shapes = 3;  ///< equilibria of a level from which the nearest is the start of the next
constexpr double probe_step = 1e-4;      ///< diagonals: far above round-off, far below an edge
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

/// What `measure` gives; an exception that a quantity may throw is its failure.
template <class Measure>
QuantityResult or_failure(const Measure& measure) {
    try {
        return measure();
    } catch (const OutputError&) {
        throw;
    } catch (const ReplayMismatch&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        QuantityResult failed;
        failed.failure = Failure{"exception", e.what()};
        return failed;
    }
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
      guard_(rest_->surface, rest_->adjacent, {problem.fixed, problem.symmetry}),
      names_(value_names(problem)) {
    for (const std::string& name : differentiated) differentiated_.push_back(index_of(name));
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
    if (m.vertices.rows() != result.vertices.rows() || m.own != x.tail(space_.num_own())) return false;
    if ((m.vertices - result.vertices).rowwise().norm().maxCoeff() > same_shape * rest_->diagonal) return false;
    result.values = m.values;
    result.dJ_dv = m.dJ_dv;
    result.dJ_down = m.dJ_down;
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
    const Equilibrium end = shell_->solve(wanted.loads, wanted.motions, options);
    if (end.status != SolveStatus::converged) {
        result.status =
            end.status == SolveStatus::unstable ? EvaluationStatus::unstable : EvaluationStatus::not_converged;
        result.reason = end.reason;
        return false;
    }
    last_ = shell_->poses();
    last_x_ = x;
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

/// What a program gave is kept before anything else happens: a run that dies pays for nothing twice.
QuantityResult ShapeEvaluator::call(const Quantity& quantity, const QuantityRequest& request,
                                    const std::string& surface) const {
    if (!journal_ || quantity.program.empty()) return quantity.evaluate(request);
    const std::string& name = quantity.names[0];
    if (auto known = journal_->find_call(request.evaluation, name)) {
        if (known->surface != surface)
            throw ReplayMismatch(text("evaluation ", request.evaluation, ": the surface that ", name,
                                      " was given is not the recorded one, bit by bit: another machine, another "
                                      "version of Strake or of its libraries, or another surface file"));
        return std::move(known->result);
    }
    const auto begin = std::chrono::steady_clock::now();
    JournalCall made{request.evaluation, name, content_hash(quantity.program), surface, {}, 0};
    made.result = quantity.evaluate(request);
    made.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    // A failure that ends the run is no answer: the next start asks again.
    if (!made.result.failure || quantity.failing_shortens_step) journal_->add(made);
    return std::move(made.result);
}

void ShapeEvaluator::measure(int number, const Eigen::VectorXd& x, ShapeEvaluation& result) {
    const TriMesh surface = with_vertices(rest_->surface, result.vertices);
    if (journal_) result.surface = content_hash(surface);
    std::vector<Points> dJ_dv;
    std::vector<Eigen::VectorXd> dJ_down;
    for (const Quantity& quantity : problem_.quantities) {
        // A program is asked for gradients only if one of its values needs them.
        const int first = static_cast<int>(result.values.size()),
                  next = first + static_cast<int>(quantity.names.size());
        const bool gradients =
            std::any_of(differentiated_.begin(), differentiated_.end(), [&](int i) { return first <= i && i < next; });
        QuantityResult measured = or_failure([&] {
            return call(quantity,
                        {surface, gradients, number, space_.level, physical_values(space_, x), own_values(space_, x),
                         stop_wanted_},
                        result.surface);
        });
        result.remarks.insert(result.remarks.end(), measured.remarks.begin(), measured.remarks.end());
        if (!measured.failure && measured.values.size() != quantity.names.size())
            measured.failure = Failure{"wrong_count", text(measured.values.size(), " values, expected ",
                                                           quantity.names.size(), " (", quantity.names[0], ", ...)")};
        for (const double value : measured.values)
            if (!measured.failure && !std::isfinite(value))
                measured.failure = Failure{"not_finite", text(quantity.names[0], ": the value ", value)};
        if (measured.failure) {
            result.status = EvaluationStatus::quantity_failed;
            result.may_go_on = quantity.failing_shortens_step;
            result.reason = text(quantity.names[0], ": ", measured.failure->kind, ": ", measured.failure->message);
            result.values.clear();
            return;
        }
        result.values.insert(result.values.end(), measured.values.begin(), measured.values.end());
        measured.dJ_dv.resize(measured.values.size());
        dJ_dv.insert(dJ_dv.end(), measured.dJ_dv.begin(), measured.dJ_dv.end());
        measured.dJ_down.resize(measured.values.size());
        dJ_down.insert(dJ_down.end(), measured.dJ_down.begin(), measured.dJ_down.end());
    }
    for (const int i : differentiated_) {
        if (dJ_dv[i].rows() != surface.num_vertices() || !dJ_dv[i].allFinite()) {
            result.status = EvaluationStatus::quantity_failed;
            result.may_go_on = false;
            result.reason = text(names_[i], ": no finite vertex sensitivities (", dJ_dv[i].rows(), " rows for ",
                                 surface.num_vertices(), " vertices); a gradient-free method (cobyla) can do without");
            return;
        }
        if (!own_sensitivities_usable(i, dJ_down[i], result)) return;
        result.dJ_dv.push_back(std::move(dJ_dv[i]));
        result.dJ_down.push_back(std::move(dJ_down[i]));
    }
    result.status = EvaluationStatus::ok;
}

/// None given: the value depends on the shape alone. Not known ones are left to differences where these are allowed.
bool ShapeEvaluator::own_sensitivities_usable(int i, Eigen::VectorXd& dJ_down, ShapeEvaluation& result) const {
    const int count = space_.num_own();
    if (dJ_down.size() == 0) dJ_down = Eigen::VectorXd::Zero(count);
    std::string what;
    if (dJ_down.size() != count) what = text(dJ_down.size(), " derivatives for ", count, " variables of the case");
    for (int j = 0; j < count && what.empty(); ++j)
        if (std::isinf(dJ_down[j]) || (std::isnan(dJ_down[j]) && !problem_.optimize.finite_differences))
            what = text("no finite derivative by ", rest_->own[j].name);
    if (what.empty()) return true;
    result.status = EvaluationStatus::quantity_failed;
    result.may_go_on = false;
    result.reason = text(names_[i], ": ", what, "; optimize.finite_differences or a gradient-free method (cobyla) ",
                         "can do without");
    return false;
}

ShapeEvaluation ShapeEvaluator::evaluate(const Eigen::VectorXd& x, int number) {
    ShapeEvaluation result;
    const bool begins = std::exchange(enters_, false);
    if (!deform(x, result)) return result;
    if (!(takes_over_ && begins && take_over(x, result))) measure(number, x, result);
    if (result.status == EvaluationStatus::ok)
        last_measured_ = {result.vertices, x.tail(space_.num_own()), result.values, result.dJ_dv, result.dJ_down};
    return result;
}

void ShapeEvaluator::differentiate(ShapeEvaluation& evaluation) {
    if (evaluation.status != EvaluationStatus::ok || !last_)
        throw InvalidInput("differentiate: the last evaluation gave no shape");
    evaluation.sensitivities = shell_->adjoint(evaluation.dJ_dv);
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
    if (!(last_ && last_x_ == x) && !deform(x, unused)) return {};
    return present_product(space_, *shell_, d);
}

std::optional<Eigen::VectorXd> ShapeEvaluator::slopes_along(const Points& vertices, const Points& direction) const {
    Eigen::VectorXd slopes(static_cast<Eigen::Index>(differentiated_.size()));
    const TriMesh surface = with_vertices(rest_->surface, vertices);
    int first = 0;
    for (const Quantity& quantity : problem_.quantities) {
        const int next = first + static_cast<int>(quantity.names.size());
        std::optional<QuantityResult> known;
        for (std::size_t i = 0; i < differentiated_.size(); ++i) {
            if (differentiated_[i] < first || differentiated_[i] >= next) continue;
            if (!quantity.program.empty()) return {};
            if (!known)
                known = or_failure([&] {
                    return quantity.evaluate({surface, true, 0, space_.level, {}, {}, stop_wanted_});
                });
            if (known->failure) return {};
            slopes[static_cast<Eigen::Index>(i)] =
                known->dJ_dv.at(differentiated_[i] - first).cwiseProduct(direction).sum();
        }
        first = next;
    }
    return slopes;
}

std::optional<double> ShapeEvaluator::curvature_along(const Eigen::VectorXd& x, const DesignSpace& finer,
                                                      const Eigen::VectorXd& step, const Eigen::VectorXd& weight) {
    ShapeEvaluation shape;
    if (!only_loads(finer) || !only_loads(space_) || finer.num_own() > 0 || !deform(x, shape)) return {};
    const Points moved = shell_->response({load_forces(finer, step)}, probe_tolerance)[0];
    const double size = std::sqrt(moved.rowwise().squaredNorm().maxCoeff());
    if (!(size > 0)) return {};
    const double h = probe_step * rest_->diagonal / size;
    const auto here = slopes_along(shape.vertices, moved), there = slopes_along(shape.vertices + h * moved, moved);
    if (!here || !there) return {};
    const double curvature = weight.dot(*there - *here) / h;
    return std::isfinite(curvature) ? std::optional(curvature) : std::nullopt;
}

}  // namespace strake
