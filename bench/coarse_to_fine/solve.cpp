#include "bench/coarse_to_fine/solve.hpp"

#include "bench/coarse_to_fine/cma_es.hpp"
#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "optimize/evaluate/constraints.hpp"
#include "optimize/evaluate/validity.hpp"
#include "optimize/nlp/minimizer.hpp"
#include "optimize/run/coarse_to_fine.hpp"
#include "optimize/run/method_choice.hpp"
#include "optimize/space/refinement.hpp"

#include <cmath>
#include <ctime>

namespace strake::evidence {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// Adds one evaluation to the trace.
struct Tracer {
    Solve& solve;
    int variables = 0;  ///< of the level
    int choosing = 0;   ///< differences by which its patches were chosen
    bool has_gradients = true;
    double begin = cpu_seconds();
    double enough = -std::numeric_limits<double>::infinity();
    bool has_enough() const { return !solve.trace.empty() && solve.trace.back().best <= enough; }
    /// @param objective as minimized; NaN: no value. @param tolerance of the violation
    void add(double objective, double violation, double tolerance) {
        TracePoint point = solve.trace.empty() ? TracePoint{} : solve.trace.back();
        ++point.evaluation;
        point.paid += 1 + (has_gradients && std::isfinite(objective) ? variables : 0) + std::exchange(choosing, 0);
        point.cpu = cpu_seconds() - begin;
        if (!std::isfinite(objective))
            ++solve.failures;
        else if (violation <= tolerance && !(point.best <= objective))
            point.best = objective;
        point.objective = objective;
        point.violation = violation;
        if (solve.trace.empty()) solve.start = objective;
        solve.trace.push_back(point);
        solve.evaluations = point.evaluation;
        solve.final = point.best;
    }
};

void run_strake(const EvidenceProblem& evidence, Solver solver, Method method, int budget, Tracer& tracer) {
    Solve& result = tracer.solve;
    const bool has_fields = solver == Solver::fields || solver == Solver::as_it_comes;
    Problem problem = has_fields ? with_automatic_fields(evidence).problem : evidence.problem;
    if (solver == Solver::as_it_comes) problem.parameters.kinds = {VariableKind::normal_load};
    if (solver == Solver::finest) problem.tree = finest_only(problem.tree);
    const bool chooses =  // of fields as a case has it that states none
        solver == Solver::adaptive || (solver == Solver::fields && problem.constraints.empty());
    if (chooses) problem.parameters.split = SplitRule::sensitivity;
    problem.optimize.method = method;
    problem.optimize.max_evaluations = budget;
    RunEvents events;
    events.stop_wanted = [&] { return tracer.has_enough(); };
    std::optional<DesignSpace> above;
    events.level = [&](const LevelStart& level) {
        const bool chosen = above && chooses && tracer.has_gradients;
        if (const auto all = chosen ? prospect(*above, VectorXd::Zero(above->size())) : std::nullopt)
            tracer.choosing = all->children.space.size();
        tracer.variables = level.space.size();
        above = level.space;
    };
    events.evaluation = [&](const EvaluationRecord& record) {
        if (!record.reason.empty()) result.notes.push_back(record.reason);
        if (record.is_taken_over) return;  // nothing was computed
        const double sign = problem.maximize ? -1 : 1;
        tracer.add(record.status == "ok" ? sign * record.objective : std::numeric_limits<double>::quiet_NaN(),
                   record.max_violation, problem.optimize.constraint_tolerance);
    };
    events.note = [&](const std::string& words) { result.notes.push_back(words); };
    events.level_end = [&](const LevelSummary& level) {
        result.notes.push_back(text("level ", level.level, ": ", level.patches, " patches, ", level.variables,
                                    " variables, ", level.evaluations, " evaluations, ", level.objective_start, " to ",
                                    level.objective_end, ": ", level.stop));
        result.variables = std::max(result.variables, level.variables);
        result.levels += text(result.levels.empty() ? "" : "+", level.variables);
        result.inherited_change = std::max(result.inherited_change, level.inherited_objective_change);
    };
    const RunResult run = optimize(problem, events);
    result.status = run.status;
    result.reason = run.reason;
    result.vertices = run.vertices;
    if (run.best_evaluation > 0) result.patches = run.space.patches();
}

/// A linear motion as a nonlinear program for the same minimizer, guard and constraints as Strake's own.
class Comparator {
public:
    Comparator(const EvidenceProblem& evidence, const ComparedMotion& motion, Tracer& tracer)
        : problem_(evidence.problem),
          has_gradients_(evidence.has_gradients),
          motion_(motion),
          tracer_(tracer),
          guard_(problem_.surface, adjacency(problem_.surface)) {
        // There are no prisms: a triangle counts as inverted when its normal turns by more than 90 degrees.
        at_rest_.rotation.assign(problem_.surface.num_triangles(), Eigen::Quaterniond::Identity());
        at_rest_.displacement = Points::Zero(problem_.surface.num_triangles(), 3);
        for (const Quantity& q : problem_.quantities) names_.insert(names_.end(), q.names.begin(), q.names.end());
        lower_ = motion_.lower.cwiseProduct(motion_.weight);
        upper_ = motion_.upper.cwiseProduct(motion_.weight);
        const Eigen::Index n = motion_.size(), all = n + static_cast<Eigen::Index>(parameters().size());
        lower_.conservativeResize(all);
        upper_.conservativeResize(all);
        for (Eigen::Index i = n; i < all; ++i) {
            const ProgramParameter& p = parameters()[static_cast<std::size_t>(i - n)];
            lower_[i] = (p.min - p.start) / unit(p);
            upper_[i] = (p.max - p.start) / unit(p);
        }
    }

    /// @param slopes of constraints that are built in are known, as Strake's own search by models knows them
    NonlinearProgram program(bool slopes) {
        NonlinearProgram p;
        p.start = VectorXd::Zero(lower_.size());
        p.lower = lower_;
        p.upper = upper_;
        std::tie(p.num_inequalities, p.num_equalities) = count_constraints(problem_.constraints);
        p.evaluate = [this](const VectorXd& y) { return evaluate(y); };
        if (has_gradients_)
            p.differentiate = [this](const VectorXd& y, Evaluation& sample) { differentiate(y, sample); };
        else
            p.differences.emplace().step = problem_.optimize.difference_step;
        if (motion_.metric.size() > 0) {
            p.metric = MatrixXd::Identity(lower_.size(), lower_.size());
            p.metric.topLeftCorner(motion_.size(), motion_.size()) = motion_.metric;
        }
        add_cheap_values(p, slopes);
        return p;
    }
    Points vertices(const VectorXd& y) const { return motion_.vertices(of_motion(y)); }

private:
    /// Parameters of programs follow the variables of the motion.
    const std::vector<ProgramParameter>& parameters() const { return problem_.program_parameters; }
    static double unit(const ProgramParameter& p) { return 0.5 * (p.max - p.min); }
    VectorXd of_motion(const VectorXd& y) const { return y.head(motion_.size()).cwiseQuotient(motion_.weight); }

    QuantityRequest request(const TriMesh& surface, const VectorXd& y, bool sensitivities) const {
        QuantityRequest request{surface, sensitivities, tracer_.solve.evaluations, 0, {}};
        for (std::size_t k = 0; k < parameters().size(); ++k) {
            const ProgramParameter& p = parameters()[k];
            request.parameters.emplace_back(p.name,
                                            p.start + unit(p) * y[motion_.size() + static_cast<Eigen::Index>(k)]);
        }
        return request;
    }

    int index(const std::string& name) const {
        return static_cast<int>(std::find(names_.begin(), names_.end(), name) - names_.begin());
    }

    /// The value that stands for the objective in the cheap program; empty: none.
    std::string cheap_objective() const {
        for (const CheapModel& model : problem_.cheap_models)
            if (model.value == problem_.objective) return model.low;
        return {};
    }

    /// Constraints that no program tells are known at each design beside the programs, and a cheap model of the
    /// objective, as in Strake's own runs.
    void add_cheap_values(NonlinearProgram& p, bool slopes) {
        const auto kind = [&](const std::string& name) {
            for (const Quantity& q : problem_.quantities)
                if (std::ranges::find(q.names, name) != q.names.end())
                    return is_built_in(q) ? LowFidelityValue::same : LowFidelityValue::none;
            return LowFidelityValue::none;
        };
        if (has_gradients_ || kind(problem_.objective) == LowFidelityValue::same) return;
        LowFidelity low;
        low.values.push_back(cheap_objective().empty() ? LowFidelityValue::none : LowFidelityValue::approximate);
        for (const bool equalities : {false, true})
            for (const Constraint& c : problem_.constraints)
                low.values.insert(low.values.end(),
                                  equalities ? c.equals.has_value() : c.min.has_value() + c.max.has_value(),
                                  kind(c.quantity));
        auto built_in = std::make_shared<NonlinearProgram>(p);
        built_in->evaluate = [this](const VectorXd& y) { return evaluate_built_in(y); };
        const auto has_slopes = [&](const Constraint& c) {
            return std::ranges::none_of(problem_.quantities, [&](const Quantity& q) {
                return is_built_in(q) && !q.has_sensitivities &&
                       std::ranges::find(q.names, c.quantity) != q.names.end();
            });
        };
        if (slopes && cheap_objective().empty() && std::ranges::all_of(problem_.constraints, has_slopes)) {
            built_in->differences.reset();
            built_in->differentiate = [this](const VectorXd& y, Evaluation& sample) {
                differentiate_built_in(y, sample);
            };
        }
        low.program = std::move(built_in);
        if (!cheap_objective().empty())
            low.first_scale = [this, start = p.start] {
                VectorXd scale = VectorXd::Ones(1 + static_cast<Eigen::Index>(rows_.rows.size()));
                scale[0] = tracer_.solve.start / evaluate_built_in(start).objective;
                return scale;
            };
        p.low_fidelity = std::move(low);
    }

    /// Of each quantity; without values and slopes where it is not built in.
    std::vector<QuantityResult> built_in_at(const VectorXd& y, bool slopes, std::string& failure) const {
        const TriMesh surface = with_vertices(problem_.surface, vertices(y));
        std::vector<QuantityResult> results(problem_.quantities.size());
        for (std::size_t i = 0; i < results.size(); ++i) {
            const Quantity& quantity = problem_.quantities[i];
            if (is_built_in(quantity)) results[i] = quantity.evaluate(request(surface, y, slopes));
            if (results[i].failure) failure = results[i].failure->message;
        }
        return results;
    }

    /// Constraints and the cheap objective; 0 where a program would tell.
    Evaluation evaluate_built_in(const VectorXd& y) {
        Evaluation sample;
        std::vector<double> values;
        std::vector<QuantityResult> results = built_in_at(y, false, sample.failure);
        for (std::size_t i = 0; i < results.size(); ++i) {
            results[i].values.resize(problem_.quantities[i].names.size(), std::numeric_limits<double>::quiet_NaN());
            values.insert(values.end(), results[i].values.begin(), results[i].values.end());
        }
        const std::string low = cheap_objective();
        sample.objective = low.empty() ? 0 : sign() * values[index(low)];
        sample.constraints.resize(static_cast<Eigen::Index>(rows_.rows.size()));
        for (std::size_t i = 0; i < rows_.rows.size(); ++i) {
            const double c = rows_.rows[i].of(values[rows_.rows[i].value]);
            sample.constraints[static_cast<Eigen::Index>(i)] = std::isnan(c) ? 0 : c;
        }
        return sample;
    }

    /// Of constraints that are built in; zero for the others and the objective.
    void differentiate_built_in(const VectorXd& y, Evaluation& sample) {
        dJ_dv_.clear();
        dJ_dp_.clear();
        const std::vector<QuantityResult> results = built_in_at(y, true, sample.failure);
        const Points none = Points::Zero(problem_.surface.num_vertices(), 3);
        for (std::size_t i = 0; i < results.size(); ++i)
            for (std::size_t k = 0; k < problem_.quantities[i].names.size(); ++k) {
                const QuantityResult& r = results[i];
                dJ_dv_.push_back(k < r.dJ_dv.size() ? r.dJ_dv[k] : none);
                dJ_dp_.push_back(k < r.dJ_dp.size() && r.dJ_dp[k].size() > 0 ? r.dJ_dp[k] : no_parameters());
            }
        differentiate(y, sample);
    }

    Evaluation evaluate(const VectorXd& y) {
        Evaluation sample;
        const TriMesh surface = with_vertices(problem_.surface, vertices(y));
        sample.failure = guard_.defect(surface.vertices, at_rest_);
        std::vector<double> values;
        dJ_dv_.clear();
        dJ_dp_.clear();
        for (std::size_t i = 0; sample.failure.empty() && i < problem_.quantities.size(); ++i) {
            const Quantity& quantity = problem_.quantities[i];
            const QuantityResult r = quantity.combination ? combined(*quantity.combination, values)
                                                          : quantity.evaluate(request(surface, y, has_gradients_));
            if (r.failure) sample.failure = r.failure->message;
            values.insert(values.end(), r.values.begin(), r.values.end());
            dJ_dv_.insert(dJ_dv_.end(), r.dJ_dv.begin(), r.dJ_dv.end());
            for (std::size_t k = 0; k < quantity.names.size(); ++k)
                dJ_dp_.push_back(k < r.dJ_dp.size() && r.dJ_dp[k].size() > 0 ? r.dJ_dp[k] : no_parameters());
        }
        double violation = 0;
        if (sample.failure.empty()) violation = fill(values, sample);
        if (!sample.failure.empty()) tracer_.solve.notes.push_back(sample.failure);
        tracer_.add(sample.objective, violation, problem_.optimize.constraint_tolerance);
        return sample;
    }

    /// A formula of the values so far.
    QuantityResult combined(const Combination& combination, const std::vector<double>& values) const {
        VectorXd of(static_cast<Eigen::Index>(combination.of.size())), slopes;
        for (Eigen::Index i = 0; i < of.size(); ++i) of[i] = values[index(combination.of[static_cast<std::size_t>(i)])];
        QuantityResult result{.values = {combination.value(of, &slopes)}, .dJ_dv = {}, .failure = {}};
        if (!has_gradients_) return result;
        result.dJ_dv = {Points::Zero(problem_.surface.num_vertices(), 3)};
        result.dJ_dp = {no_parameters()};
        for (Eigen::Index i = 0; i < of.size(); ++i) {
            const auto value = static_cast<std::size_t>(index(combination.of[static_cast<std::size_t>(i)]));
            result.dJ_dv[0] += slopes[i] * dJ_dv_[value];
            result.dJ_dp[0] += slopes[i] * dJ_dp_[value];
        }
        return result;
    }

    /// Objective and constraints from the values; the largest violation.
    double fill(const std::vector<double>& values, Evaluation& sample) {
        if (rows_.rows.empty() && !problem_.constraints.empty()) {
            std::vector<int> at;
            for (const Constraint& c : problem_.constraints) at.push_back(index(c.quantity));
            rows_ = constraint_rows(problem_.constraints, at, at, values);
        }
        sample.objective = sign() * values[index(problem_.objective)];
        sample.constraints.resize(static_cast<Eigen::Index>(rows_.rows.size()));
        double violation = 0;
        for (std::size_t i = 0; i < rows_.rows.size(); ++i) {
            const double c = rows_.rows[i].of(values[rows_.rows[i].value]);
            sample.constraints[static_cast<Eigen::Index>(i)] = c;
            violation = std::max(violation, static_cast<int>(i) < rows_.num_inequalities ? c : std::abs(c));
        }
        return violation;
    }

    void differentiate(const VectorXd& y, Evaluation& sample) {
        const VectorXd x = of_motion(y);
        const auto by_y = [&](int value) {
            VectorXd g(lower_.size());
            g.head(motion_.size()) = motion_.gradient(x, dJ_dv_[value]).cwiseQuotient(motion_.weight);
            for (std::size_t k = 0; k < parameters().size(); ++k) {
                const auto at = static_cast<Eigen::Index>(k);
                g[motion_.size() + at] = unit(parameters()[k]) * dJ_dp_[static_cast<std::size_t>(value)][at];
            }
            return g;
        };
        sample.gradient = sign() * by_y(index(problem_.objective));
        sample.jacobian.resize(static_cast<Eigen::Index>(rows_.rows.size()), lower_.size());
        for (std::size_t i = 0; i < rows_.rows.size(); ++i)
            sample.jacobian.row(static_cast<Eigen::Index>(i)) =
                rows_.rows[i].sign / rows_.rows[i].scale * by_y(rows_.rows[i].gradient).transpose();
    }

    double sign() const { return problem_.maximize ? -1 : 1; }
    VectorXd no_parameters() const { return VectorXd::Zero(static_cast<Eigen::Index>(parameters().size())); }

    const Problem& problem_;
    const bool has_gradients_;
    const ComparedMotion& motion_;
    Tracer& tracer_;
    ValidityGuard guard_;
    Poses at_rest_;
    std::vector<std::string> names_;
    ConstraintRows rows_;
    std::vector<Points> dJ_dv_;
    std::vector<VectorXd> dJ_dp_;
    VectorXd lower_, upper_;  ///< of the program's variables
};

/// Above this, the dense models of sqp cost minutes a step; a first-order method that ends is then taken at its word.
constexpr int max_for_dense_models = 300;
struct EndedByItself {};

ComparedMotion comparator_motion(const EvidenceProblem& evidence, Solver solver, Method method) {
    if (solver == Solver::lattice_4x4x4) return spline_lattice(evidence, {4, 4, 4});
    if (solver == Solver::lattice_8x4x2) return spline_lattice(evidence, {8, 4, 2});
    if (solver == Solver::box_12 || solver == Solver::cma_es_12) return bezier_box(evidence, 12);
    if (solver == Solver::box_24) return bezier_box(evidence, 24);
    // As many variables as the last level of the tree has: those of its patches that are not wholly held.
    if (solver == Solver::ffd) return bezier_box(evidence, variables_of_last_level(evidence.problem));
    if (method == Method::sqp) throw InvalidInput("filtered vertices are too many for the dense models of sqp");
    return filtered_vertices(evidence);
}

void run_comparator(const EvidenceProblem& evidence, const ComparedMotion& motion, Method method, int budget,
                    Tracer& tracer) {
    Solve& result = tracer.solve;
    result.variables = tracer.variables = motion.size() + static_cast<int>(evidence.problem.program_parameters.size());
    result.levels = text(result.variables);
    result.notes.push_back(motion.name);
    Comparator comparator(evidence, motion, tracer);
    MinimizeOptions how = options_of_searches(evidence.problem.optimize);
    how.method = method;
    how.max_evaluations = budget;
    if (!how.limits_by_models)
        for (int j = motion.size(); j < result.variables; ++j) how.first_alone.push_back(j);
    how.on_step = [&](const MinimizeStep&) { return !tracer.has_enough(); };
    how.on_event = [&](const std::string& words) {
        result.notes.push_back(words);
        const bool is_second_opinion = words.find("sqp goes on") != std::string::npos;
        if (is_second_opinion && motion.size() > max_for_dense_models) throw EndedByItself{};
    };
    MinimizeResult end;
    try {
        end = minimize(comparator.program(method == Method::model), how);
    } catch (const EndedByItself&) {
        result.status = "converged";
        result.reason = result.notes.back();
        return;
    }
    result.status = end.stop == MinimizeStop::converged       ? "converged"
                    : end.stop == MinimizeStop::evaluations   ? "budget"
                    : end.stop == MinimizeStop::stopped       ? "enough"
                    : end.stop == MinimizeStop::no_valid_step ? "no_valid_step"
                    : end.stop == MinimizeStop::roundoff      ? "roundoff"
                                                              : "failed";
    result.reason = end.reason;
    result.vertices = comparator.vertices(end.x);
}

}  // namespace

const std::vector<Solver>& all_solvers() {
    static const std::vector<Solver> all{Solver::fields,        Solver::as_it_comes,   Solver::adaptive,
                                         Solver::uniform,       Solver::finest,        Solver::ffd,
                                         Solver::box_12,        Solver::box_24,        Solver::cma_es_12,
                                         Solver::lattice_4x4x4, Solver::lattice_8x4x2, Solver::filtered};
    return all;
}

std::string to_string(Solver solver) {
    switch (solver) {
        case Solver::fields:
            return "fields";
        case Solver::as_it_comes:
            return "as_it_comes";
        case Solver::lattice_4x4x4:
            return "lattice_4x4x4";
        case Solver::lattice_8x4x2:
            return "lattice_8x4x2";
        case Solver::adaptive:
            return "adaptive";
        case Solver::uniform:
            return "uniform";
        case Solver::finest:
            return "finest";
        case Solver::ffd:
            return "ffd";
        case Solver::box_12:
            return "box_12";
        case Solver::box_24:
            return "box_24";
        case Solver::cma_es_12:
            return "cma_es_12";
        case Solver::filtered:
            return "filtered";
    }
    return "unknown";
}

std::string to_string(Method method) {
    switch (method) {
        case Method::sqp:
            return "sqp";
        case Method::model:
            return "model";
        case Method::mma:
            return "mma";
        case Method::lbfgs:
            return "lbfgs";
        case Method::cobyla:
            return "cobyla";
        case Method::bobyqa:
            return "bobyqa";
        default:
            return "other";
    }
}

int variables_of_last_level(const Problem& problem) {
    std::vector<char> held(problem.surface.num_triangles(), 0);
    for (const int t : problem.fixed) held[t] = 1;
    int each = 0, free = 0;
    for (const VariableKind kind : problem.parameters.kinds)
        each += kind == VariableKind::load ? 3 : kind == VariableKind::strain ? 6 : 1;
    for (const Patch& patch : problem.tree.levels.back().patches)
        free += std::any_of(patch.triangles.begin(), patch.triangles.end(), [&](int t) { return !held[t]; });
    return each * free;
}

Solve solve(const EvidenceProblem& problem, Solver solver, Method method, int budget, double enough) {
    Solve result;
    result.problem = problem.name;
    result.solver = to_string(solver);
    result.method = to_string(method);
    Tracer tracer{result};
    tracer.has_gradients = problem.has_gradients;
    tracer.enough = enough;
    const bool is_ours = solver == Solver::fields || solver == Solver::as_it_comes || solver == Solver::adaptive ||
                         solver == Solver::uniform || solver == Solver::finest;
    if (is_ours) {
        run_strake(problem, solver, method, budget, tracer);
    } else if (solver == Solver::cma_es_12) {
        const ComparedMotion motion = comparator_motion(problem, solver, method);
        result.variables = tracer.variables = motion.size();
        result.levels = text(motion.size());
        result.status = "budget";
        const double step = MinimizeOptions().first_step / std::sqrt(motion.size());
        Comparator comparator(problem, motion, tracer);
        minimize_by_cma_es(comparator.program(false), budget, problem.problem.optimize.seed, step);
    } else {
        run_comparator(problem, comparator_motion(problem, solver, method), method, budget, tracer);
    }
    return result;
}

Solve solve(const EvidenceProblem& problem, const ComparedMotion& motion, Method method, int budget) {
    Solve result;
    result.problem = problem.name;
    result.solver = motion.name;
    result.method = to_string(method);
    Tracer tracer{result};
    tracer.has_gradients = problem.has_gradients;
    run_comparator(problem, motion, method, budget, tracer);
    return result;
}

}  // namespace strake::evidence
