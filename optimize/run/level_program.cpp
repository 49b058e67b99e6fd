#include "optimize/run/level_program.hpp"

#include "core/error.hpp"
#include "optimize/nlp/program/first_order.hpp"
#include "optimize/nlp/program/methods.hpp"
#include "optimize/nlp/surrogate/mirror_directions.hpp"
#include "optimize/run/method_choice.hpp"
#include "optimize/run/run_verdict.hpp"
#include "optimize/space/mirror.hpp"
#include "optimize/space/motion_images.hpp"
#include "optimize/space/motion_limit.hpp"
#include "optimize/space/response_metric.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <span>

namespace strake {
namespace {

const Quantity& quantity_of(const Problem& problem, const std::string& value) {
    for (const Quantity& quantity : problem.quantities)
        if (std::find(quantity.names.begin(), quantity.names.end(), value) != quantity.names.end()) return quantity;
    throw InvalidInput(text("no quantity is called '", value, "'"));
}

/// The objective first, then constrained values, each once.
std::vector<std::string> wanted_names(const Problem& problem) {
    if (problem.objective.empty()) throw InvalidInput("the case has no objective: give minimize or maximize");
    std::vector<std::string> names{problem.objective};
    for (const Constraint& c : problem.constraints)
        if (std::find(names.begin(), names.end(), c.quantity) == names.end()) names.push_back(c.quantity);
    return names;
}

/// Of the motion limit: more than what separates two solutions of the same equilibrium, and inherited shapes.
constexpr double min_slack = 5e-7;
/// By differences every design has others around it. More would be a limit of its own, but where noise asks for it.
constexpr double max_slack = 5e-3, max_slack_in_noise = 0.05;
constexpr double max_difference_step = 0.1;  ///< of a step of 1 in the metric: beyond, a difference is no slope
constexpr double slack_over_step = 1.2;      ///< displacements are not quite linear in the step
/// Vertices that a step of the trust region may bring to their limit.
constexpr double near_limit = 0.6;
/// Determinants of triangles that a step may fold.
constexpr double nearly_folded = 0.6;

constexpr double same_value = 1e-6;  ///< of the largest: computed on the same shape

constexpr double motion_step = 1e-3;  ///< diagonals, whose price is told

/// Methods that know nothing of the limit but that points beyond it are moved inside: they search where one variable
/// alone stays within.
bool needs_narrow_bounds(const OptimizeOptions& options) {
    const MethodFacts& method = method_facts(options.method);
    return options.starts > 1 || method.is_global || (method.needs_gradients && method.method != Method::sqp);
}

/// A cheap program is worth its place: it stands for values of programs, or tells a search by models which designs meet
/// a constraint. Functions without gradients that are no programs may be expensive, too: they are called for
/// evaluations only.
bool uses_cheap_program(const Problem& problem) {
    if (problem.optimize.method == Method::sqp) return !problem.cheap_models.empty();
    if (problem.optimize.method != Method::model) return false;
    const auto is_unknown = [](const Quantity& quantity) {
        return quantity.program.empty() && !quantity.combination && !quantity.has_sensitivities;
    };
    return std::none_of(problem.quantities.begin(), problem.quantities.end(), is_unknown) &&
           std::any_of(problem.constraints.begin(), problem.constraints.end(),
                       [&](const Constraint& c) { return is_cheap(problem, c.quantity); });
}

bool is_of_patches_alone(const DesignSpace& space) {
    return std::ranges::all_of(space.variables, [](const Variable& variable) { return variable.patch >= 0; });
}

/// Sum of weight * sensitivities, over those that count for design variables.
ShellSensitivities weighted_sum(const std::vector<const ShellSensitivities*>& all, const Eigen::VectorXd& weight) {
    ShellSensitivities sum = *all[0];
    sum.vertex *= weight[0];
    sum.force *= weight[0];
    sum.prism_height *= weight[0];
    sum.wrench *= weight[0];
    sum.surface *= weight[0];
    for (Eigen::Index i = 1; i < weight.size(); ++i) {
        const ShellSensitivities& one = *all[static_cast<std::size_t>(i)];
        if (one.vertex.rows() > 0) sum.vertex += weight[i] * one.vertex;
        sum.force += weight[i] * one.force;
        sum.prism_height += weight[i] * one.prism_height;
        sum.wrench += weight[i] * one.wrench;
        sum.surface += weight[i] * one.surface;
    }
    return sum;
}

}  // namespace

std::vector<std::string> LevelProgram::differentiated_names(const Problem& problem) {
    const MethodFacts& method = method_facts(problem.optimize.method);
    std::vector<std::string> names;
    for (const std::string& name : wanted_names(problem)) {
        if (quantity_of(problem, name).has_sensitivities && (method.needs_gradients || method.is_global))
            names.push_back(name);
        else if (method.needs_gradients && !problem.optimize.finite_differences)
            throw InvalidInput(text("method ", method.name, " needs the gradient of ", name,
                                    ", which has none; use a method without gradients (cobyla, bobyqa, ...) or "
                                    "optimize.finite_differences"));
    }
    return names;
}

LevelProgram::LevelProgram(RunState& state) : state_(state) {
    const std::vector<std::string> names = differentiated_names(state.problem);
    const auto row = [&](const std::string& name) {
        const auto at = std::find(names.begin(), names.end(), name);
        return at == names.end() ? -1 : static_cast<int>(at - names.begin());
    };
    objective_ = state.evaluator.index_of(state.problem.objective);
    objective_gradient_ = row(state.problem.objective);
    needs_differences_ = objective_gradient_ < 0;
    for (const Constraint& c : state.problem.constraints) {
        constrained_.push_back(state.evaluator.index_of(c.quantity));
        gradient_row_.push_back(row(c.quantity));
        needs_differences_ |= gradient_row_.back() < 0;
    }
    const auto& kinds = state.problem.parameters.kinds;
    has_strains_ = std::find(kinds.begin(), kinds.end(), VariableKind::strain) != kinds.end();
    std::tie(num_inequalities_, num_equalities_) = count_constraints(state.problem.constraints);
}

/// Empty: none. Short runs were not measured with it.
Eigen::MatrixXd LevelProgram::second_curvature() const {
    const DesignSpace& space = state_.space;
    const OptimizeOptions& options = state_.problem.optimize;
    if (options.method != Method::model || space.size() > max_variables_with_curvature ||
        !is_long_with_fields(state_.problem, state_.limits().evaluations))
        return {};
    if (is_of_patches_alone(space)) return options.one_curvature ? Eigen::MatrixXd() : normal_motion(space);
    return options.fields_have_one_curvature || space.num_parameters() > 0 ? Eigen::MatrixXd() : roughness(space);
}

const NonlinearProgram& LevelProgram::enter(const Eigen::VectorXd& start, bool is_widened) {
    const DesignSpace& space = state_.space;
    weight_ = space.metric.diagonal().cwiseSqrt();
    const Eigen::VectorXd inverse = weight_.cwiseInverse();
    known_ = {};
    program_ = {};
    moved_y_.resize(0);
    program_.start = start.cwiseProduct(weight_);
    program_.lower = space.lower.cwiseProduct(weight_);
    program_.upper = space.upper.cwiseProduct(weight_);
    narrow_bounds(is_widened);
    program_.num_inequalities = num_inequalities_;
    program_.num_equalities = num_equalities_;
    program_.evaluate = [this](const Eigen::VectorXd& y) { return evaluate(unscaled(y)); };
    program_.differentiate = [this](const Eigen::VectorXd&, Evaluation& sample) { differentiate(sample); };
    program_.expect = [this](const std::vector<Eigen::VectorXd>& points) {
        std::vector<Eigen::VectorXd> designs;
        for (const Eigen::VectorXd& y : points) designs.push_back(unscaled(y));
        state_.evaluator.expect(designs, state_.result.evaluations + 1);
    };
    program_.metric = inverse.asDiagonal() * space.metric * inverse.asDiagonal();
    const OptimizeOptions& options = state_.problem.optimize;
    if (const Eigen::MatrixXd second = second_curvature(); second.size() > 0)
        program_.second_curvature = inverse.asDiagonal() * second * inverse.asDiagonal();
    program_.present_metric = [this](const Eigen::VectorXd& y, const Eigen::VectorXd& d) {
        const Eigen::VectorXd product = state_.evaluator.metric_product(unscaled(y), d.cwiseQuotient(weight_));
        return product.size() > 0 ? Eigen::VectorXd(product.cwiseQuotient(weight_)) : product;
    };
    const bool may_miss = options.finite_differences &&
                          space.num_parameters() > 0;  // a program may give only some derivatives by parameters
    if ((needs_differences_ || may_miss) && method_facts(options.method).needs_gradients) {
        Differences differences;
        differences.step = std::max(options.difference_step, difference_step_);
        differences.max_step = max_difference_step;
        differences.on_step = [this](double step) {
            difference_step_ = step;
            program_.differences->step = step;
            keep_slack();
        };
        differences.missing = may_miss;
        differences.objective = objective_gradient_ < 0;
        // One row per limit: inequalities first, then equalities, as the rows are.
        std::vector<char> equalities;
        for (std::size_t i = 0; i < state_.problem.constraints.size(); ++i) {
            const Constraint& c = state_.problem.constraints[i];
            const char by_differences = gradient_row_[i] < 0;
            if (c.min) differences.rows.push_back(by_differences);
            if (c.max) differences.rows.push_back(by_differences);
            if (c.equals) equalities.push_back(by_differences);
        }
        differences.rows.insert(differences.rows.end(), equalities.begin(), equalities.end());
        program_.differences = differences;
    }
    program_.is_defined = [this](const Eigen::VectorXd& y) { return state_.evaluator.has_shape(unscaled(y)); };
    program_.refusal = [this](const Eigen::VectorXd& y) {
        std::string why = state_.evaluator.refusal(unscaled(y));
        last_failed_in_quantity_ &= why.empty();
        return why;
    };
    limit_motion();
    add_cheap_program();
    add_mirror_images();
    if (learns()) program_.known = [this] { return known_points(); };
    return program_;
}

void LevelProgram::add_mirror_images() {
    num_directions_ = static_cast<int>(program_.start.size());
    const OptimizeOptions& options = state_.problem.optimize;
    const auto has_image = [](const Variable& variable) {
        return is_load(variable.kind) || variable.kind == VariableKind::field;
    };
    const auto shape = std::span(state_.space.variables).first(static_cast<std::size_t>(state_.space.num_shape()));
    if (options.method != Method::model || options.ignores_symmetry || state_.rest->wrap ||
        !is_long_with_fields(state_.problem, state_.limits().evaluations) || !std::ranges::all_of(shape, has_image))
        return;
    if (!mirrors_) {
        mirrors_.emplace();
        for (const SymmetryPlane& plane : planes_of_symmetry(state_.rest->surface)) mirrors_->push_back({plane});
    }
    const Eigen::VectorXd inverse = weight_.cwiseInverse();
    for (std::size_t k = 0; k < mirrors_->size(); ++k) {
        MirrorPlane& mirror = (*mirrors_)[k];
        if (mirror.is_none) continue;
        const MotionImages images = motion_images(state_.space, mirror.plane);
        MirrorImage image{inverse.asDiagonal() * images.motion * inverse.asDiagonal(),
                          inverse.asDiagonal() * images.image * inverse.asDiagonal(), mirror.holds,
                          [this, k, at = program_.mirror_images.size()](bool holds) {
                              use_mirror((*mirrors_)[k], holds);
                              program_.mirror_images[at].holds = holds;
                          }};
        mirror.is_none = !mirror.has_held && !keeps_directions(program_, image);
        if (!mirror.is_none) program_.mirror_images.push_back(std::move(image));
    }
    if (std::ranges::any_of(program_.mirror_images, &MirrorImage::holds))
        num_directions_ = num_even_directions(program_);
}

Eigen::VectorXd LevelProgram::symmetric_part(const Eigen::VectorXd& change) const {
    Eigen::VectorXd part = change;
    for (const MirrorImage& mirror : program_.mirror_images)
        if (mirror.holds)
            part = 0.5 * (part + mirror.motion.completeOrthogonalDecomposition().solve(mirror.image * part)).eval();
    return part;
}

void LevelProgram::add_cheap_program() {
    if (!uses_cheap_program(state_.problem)) return;
    if (!cheap_)
        cheap_ =
            std::make_unique<CheapProgram>(state_.problem, state_.rest, state_.journal(), state_.events.stop_wanted);
    if (slack_ == 0) slack_ = min_slack;
    const CheapProgram::Level level{
        state_.space,
        rows_,
        weight_,
        [this](const Eigen::VectorXd& y) { return unscaled(y); },
        slack_,
        std::max(state_.problem.optimize.difference_step, difference_step_),
        state_.problem.optimize.method != Method::model || state_.problem.optimize.limits_by_turns,
        [this](const MotionConditions& motion, const FoldConditions& folds) { return step_limits(motion, folds); },
        [this](const std::function<void()>& call) { state_.with_unfinished_calls(call); }};
    cheap_->enter(program_, level, [this](const std::vector<std::string>& names) {
        std::vector<double> values;
        for (const std::string& name : names)
            values.push_back(current_.values.at(static_cast<std::size_t>(state_.evaluator.index_of(name))));
        return values;
    });
}

std::string LevelProgram::cheap_words(const MinimizeResult& result) const {
    const Eigen::VectorXd& scale = result.low_fidelity_scale;
    if (!cheap_ || scale.size() == 0) return "";
    std::string scales;
    for (std::size_t i = 0; i < program_.low_fidelity->values.size(); ++i)
        if (program_.low_fidelity->values[i] == LowFidelityValue::approximate)
            scales += text(scales.empty() ? "" : ", ", std::round(1000 * scale[static_cast<Eigen::Index>(i)]) / 1000);
    const double kept = std::round(100 * result.low_fidelity_kept) / 100;
    return text("cheap model (", cheap_->words(), "): rho ", scales,
                std::isfinite(kept) ? text(", its steps gained ", kept, " times the expected decrease") : "",
                ", evaluated ", cheap_->evaluations(), " times");
}

void LevelProgram::carry_designs(const Eigen::VectorXd& parent, const Eigen::VectorXd& start,
                                 const Eigen::MatrixXd& prolongation) {
    if (prolongation.cols() != parent.size() || prolongation.rows() != start.size()) return seen_.clear();
    // What is frozen now has no column, and shapes that differ in it are none of this level. Motions of strain cores
    // are inherited to first order only.
    std::vector<char> is_exact(static_cast<std::size_t>(parent.size()));
    for (Eigen::Index j = 0; j < parent.size(); ++j)
        is_exact[static_cast<std::size_t>(j)] = !has_strains_ && !prolongation.col(j).isZero(0);
    std::erase_if(seen_, [&](const SeenDesign& design) {
        if (design.x.size() != parent.size()) return true;
        for (Eigen::Index j = 0; j < parent.size(); ++j)
            if (!is_exact[static_cast<std::size_t>(j)] && design.x[j] != parent[j]) return true;
        return false;
    });
    for (SeenDesign& design : seen_) design.x = start + prolongation * (design.x - parent);
}

/// Empty: the values that the run computes itself are at the start what they were there. Else which one is not.
std::string LevelProgram::contradiction(const std::vector<double>& at_start) const {
    std::size_t i = 0;
    for (const Quantity& quantity : state_.problem.quantities)
        for (std::size_t k = 0; k < quantity.names.size(); ++k, ++i) {
            if (!quantity.program.empty()) continue;
            const double was = learned_.front().values[i], is = at_start[i];
            double largest = std::abs(is);
            for (const SeenDesign& design : learned_)
                if (!design.values.empty()) largest = std::max(largest, std::abs(design.values[i]));
            if (std::abs(is - was) > same_value * largest)
                return text("at the same shape '", quantity.names[k], "' was ", was, " there and is ", is,
                            " here; it is another quantity");
        }
    return "";
}

void LevelProgram::use_learned() {
    const std::vector<double>& at_start = seen_.front().values;
    const std::string why = at_start.empty() ? "the start fails" : contradiction(at_start);
    if (!why.empty())
        state_.note(text("the designs that are known are not used: ", why));
    else
        seen_.insert(seen_.end(), learned_.begin() + 1, learned_.end());
    learned_.clear();
}

std::vector<KnownPoint> LevelProgram::known_points() {
    if (!learned_.empty() && !seen_.empty()) use_learned();
    std::vector<KnownPoint> points;
    for (const SeenDesign& design : seen_)
        points.push_back({design.x.cwiseProduct(weight_), from_values(design.values)});
    return points;
}

void LevelProgram::learn(const DesignTable& table, const Eigen::VectorXd& start) {
    if (state_.problem.optimize.method != Method::model) return;
    const auto& variables = state_.space.variables;
    learned_.clear();
    int others = 0;
    std::string missing;
    for (int row = 0; row < table.rows(); ++row) {
        SeenDesign design{start, {}};
        bool is_here = true;
        for (std::size_t j = 0; j < table.variables.size(); ++j) {
            const auto c = static_cast<Eigen::Index>(j);
            const double step = table.designs(row, c) - table.designs(0, c);
            const auto at = std::ranges::find(variables, table.variables[j], &Variable::name);
            if (at != variables.end())
                design.x[at - variables.begin()] += step / at->unit;
            else if (step != 0)
                is_here = false, missing = table.variables[j];
        }
        if (!is_here) {
            ++others;
            continue;
        }
        for (Eigen::Index k = 0; k < table.given.cols() && table.status[static_cast<std::size_t>(row)] == "ok"; ++k)
            design.values.push_back(table.given(row, k));
        learned_.push_back(std::move(design));
    }
    state_.note(text(
        learned_.size(), " designs of ", table.name, " are known and not paid again",
        others > 0 ? text("; ", others, " more are not used: they differ in variables that this run does not have (",
                          missing, " for one); keep parameters as they were there to use them")
                   : ""));
}

Evaluation LevelProgram::from_values(const std::vector<double>& values) const {
    Evaluation known;
    if (values.empty()) {
        known.failure = "failed before";
        return known;
    }
    known.objective = sign() * values[static_cast<std::size_t>(objective_)];
    known.constraints.resize(static_cast<Eigen::Index>(rows_.rows.size()));
    for (std::size_t i = 0; i < rows_.rows.size(); ++i)
        known.constraints[static_cast<Eigen::Index>(i)] = rows_.rows[i].of(values[rows_.rows[i].value]);
    return known;
}

void LevelProgram::narrow_bounds(bool is_widened) {
    if (!needs_narrow_bounds(state_.problem.optimize) || state_.evaluator.motion_limit().is_none()) return;
    if (is_widened && !state_.begins_with_wide_ranges) return;
    const Parameters& p = state_.rest->parameters;
    const double limit = largest_limit(p), room = std::isfinite(limit) ? limit / variable_scale(p) : 1;
    Eigen::VectorXd lower = program_.lower, upper = program_.upper;
    for (int j = 0; j < state_.space.num_shape(); ++j) {
        lower[j] = std::min(std::max(lower[j], -room * weight_[j]), program_.start[j]);
        upper[j] = std::max(std::min(upper[j], room * weight_[j]), program_.start[j]);
    }
    (state_.begins_with_wide_ranges ? program_.lower_of_starts : program_.lower) = std::move(lower);
    (state_.begins_with_wide_ranges ? program_.upper_of_starts : program_.upper) = std::move(upper);
}

void LevelProgram::keep_slack() {
    slack_ = min_slack;
    if (!program_.differences) return;
    const int shape = state_.space.num_shape();
    const double widest = shape > 0 ? 1 / weight_.head(shape).minCoeff() : 0;  // a step of 1, over the limit
    slack_ = std::clamp(slack_over_step * program_.differences->step * widest, min_slack,
                        difference_step_ > 0 ? max_slack_in_noise : max_slack);
}

void LevelProgram::limit_motion() {
    if (state_.evaluator.motion_limit().is_none()) return;
    keep_slack();
    program_.within = [this](const Eigen::VectorXd& y) {
        // The start is the shape of the level above, whose slack may have been less.
        const Eigen::VectorXd x = unscaled(y);
        const bool is_start = y == program_.start;
        const Eigen::VectorXd inside =
            state_.evaluator.within(x, is_start ? min_slack : slack_, is_start ? EdgeFolds::folded : EdgeFolds::kept);
        if (inside == x) return y;
        moved_x_ = inside;
        moved_y_ = inside.cwiseProduct(weight_);
        return moved_y_;
    };
    program_.beyond = [this](const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
        const Eigen::VectorXd x0 = unscaled(from), x = unscaled(to);
        if (!state_.evaluator.is_beyond(x, slack_)) return StepLimits();
        const MotionConditions motion = state_.evaluator.motion_conditions(x, 1 - 2 * slack_);
        return step_limits(on_steps(motion, x - x0), state_.evaluator.fold_conditions_between(x0, x));
    };
}

/// With the slack, twice: the shape is then within in spite of what is not linear.
StepLimits LevelProgram::step_limits(const MotionConditions& at, const FoldConditions& folds) const {
    const Eigen::Index first = at.values.size(), more = folds.values.size();
    StepLimits limits;
    if (first + more == 0) return limits;
    limits.values.resize(first + more);
    limits.values << at.values, folds.values;
    const double unit = state_.evaluator.motion_limit().reference();
    for (std::size_t i = 0; i < at.rows.size(); ++i)
        limits.values[static_cast<Eigen::Index>(i)] += 2 * slack_ * at.rows[i].limit / unit;
    limits.slopes.resize(first + more, weight_.size());
    if (first > 0) limits.slopes.topRows(first) = at.slopes * weight_.cwiseInverse().asDiagonal();
    if (more > 0) limits.slopes.bottomRows(more) = folds.slopes * weight_.cwiseInverse().asDiagonal();
    return limits;
}

/// Of the motion limit alone.
Eigen::VectorXd LevelProgram::limit_multipliers(const Evaluation& at) const {
    const Eigen::VectorXd all = all_multipliers(program_, known_.x.cwiseProduct(weight_), at).limits;
    return all.head(std::min(all.size(), static_cast<Eigen::Index>(known_.motion.rows.size())));
}

MotionAtEnd LevelProgram::motion_at_end(const Evaluation& best) const {
    MotionAtEnd end = motion_of(state_.result, state_.evaluator.motion_limit(), 3 * slack_);
    const Eigen::VectorXd &here = best.limits.values, &known = known_.sample.limits.values;
    if (!end.is_limited || best.gradient.size() == 0 || here.size() == 0 || here.size() != known.size() ||
        here != known)
        return end;
    const Eigen::VectorXd found = limit_multipliers(best);
    Eigen::Index first = 0;
    if (found.size() == 0 || !(found.maxCoeff(&first) > 0)) return end;
    const MotionLimit& limit = state_.evaluator.motion_limit();
    const MotionLimit::Row& row = known_.motion.rows[static_cast<std::size_t>(first)];
    end.is_active = true;  // a limit of zero is active from the start on
    end.vertex = row.vertex;
    end.where = patch_at(state_.space, row.vertex);
    end.limit = row.limit / limit.diagonal();
    end.gain = -sign() * found.sum() * motion_step * limit.diagonal() / limit.reference();
    return end;
}

Eigen::VectorXd LevelProgram::unscaled(const Eigen::VectorXd& y) const {
    if (moved_y_.size() == y.size() && moved_y_ == y) return moved_x_;
    return y.cwiseQuotient(weight_).cwiseMax(state_.space.lower).cwiseMin(state_.space.upper);
}

Evaluation LevelProgram::evaluate(const Eigen::VectorXd& x) {
    Evaluation sample;
    current_ = state_.evaluate(x);
    current_x_ = x;
    Rank rank;
    double objective = std::numeric_limits<double>::quiet_NaN();
    if (current_.status == EvaluationStatus::ok) {
        if (rows_.rows.empty() && !constrained_.empty())
            rows_ = constraint_rows(state_.problem.constraints, constrained_, gradient_row_,
                                    state_.values_at_rest(current_.values));
        objective = current_.values[objective_];
        sample.objective = sign() * objective;
        sample.constraints.resize(static_cast<Eigen::Index>(rows_.rows.size()));
        rank.violation = 0;
        for (std::size_t i = 0; i < rows_.rows.size(); ++i) {
            const double c = rows_.rows[i].of(current_.values[rows_.rows[i].value]);
            sample.constraints[static_cast<Eigen::Index>(i)] = c;
            const bool equality = static_cast<int>(i) >= rows_.num_inequalities;
            rank.violation = std::max(rank.violation, equality ? std::abs(c) : c);
        }
        rank.merit = sample.objective;
        rank.feasible = rank.violation <= state_.problem.optimize.constraint_tolerance;
        current_rank_ = rank;
    } else {
        sample.failure = current_.reason;
        sample.is_of_step =
            current_.status == EvaluationStatus::not_converged || current_.status == EvaluationStatus::unstable;
        last_failed_in_quantity_ = current_.status == EvaluationStatus::quantity_failed;
        sample.is_fatal = last_failed_in_quantity_ && !current_.may_go_on;
        quantity_failed_ |= sample.is_fatal;
    }
    const bool says_nothing = !sample.failure.empty() && sample.is_of_step;
    if (learns() && !state_.is_trying && !says_nothing)
        seen_.push_back({x, sample.failure.empty() ? current_.values : std::vector<double>()});
    state_.record(x, current_, objective, rank,
                  objective_gradient_ == 0 && !current_.dJ_dv.empty() ? current_.dJ_dv[0] : Points());
    return sample;
}

void LevelProgram::differentiate(Evaluation& sample) {
    const std::size_t reported = current_.remarks.size();
    const bool came_later = current_.has_gradients_to_come && objective_gradient_ == 0;
    if (current_.has_gradients_to_come || !current_.dJ_dv.empty()) state_.differentiate(current_);
    for (std::size_t i = reported; i < current_.remarks.size(); ++i)
        state_.note(text("gradient of evaluation ", state_.result.evaluations, ": ", current_.remarks[i]));
    if (current_.status != EvaluationStatus::ok) {
        sample.failure = current_.reason;
        sample.is_fatal = !current_.may_go_on;
        quantity_failed_ |= sample.is_fatal;
        last_failed_in_quantity_ = true;
        return;
    }
    if (came_later && !current_.dJ_dv.empty()) state_.tell_sensitivities(current_, current_.dJ_dv[0]);
    sample.gradient = Eigen::VectorXd::Zero(state_.space.size());
    if (objective_gradient_ >= 0)
        sample.gradient = sign() * current_.gradients.row(objective_gradient_).transpose().cwiseQuotient(weight_);
    sample.jacobian = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows_.rows.size()), state_.space.size());
    for (std::size_t i = 0; i < rows_.rows.size(); ++i)
        if (rows_.rows[i].gradient >= 0)
            sample.jacobian.row(static_cast<Eigen::Index>(i)) =
                rows_.rows[i].sign / rows_.rows[i].scale *
                current_.gradients.row(rows_.rows[i].gradient).cwiseQuotient(weight_.transpose());
    MotionConditions motion = on_steps(state_.evaluator.motion_conditions(current_x_, near_limit));
    sample.limits = step_limits(motion, state_.evaluator.fold_conditions(current_x_, nearly_folded));
    if (known_.sensitivities.empty() || current_rank_.better_than(known_.rank)) {
        known_ = {current_x_,
                  current_rank_,
                  sample,
                  current_.sensitivities,
                  current_.dJ_dv.empty() ? Points() : current_.dJ_dv[0],
                  std::move(motion)};
        const auto without_missing = [](double g) { return std::isnan(g) ? 0.0 : g; };
        known_.sample.gradient = known_.sample.gradient.unaryExpr(without_missing).eval();
        known_.sample.jacobian = known_.sample.jacobian.unaryExpr(without_missing).eval();
    }
}

bool LevelProgram::gives_lagrangian() const {
    return !needs_differences_ && method_facts(state_.problem.optimize.method).needs_gradients;
}

bool LevelProgram::has_choice() const {
    const Parameters& p = state_.rest->parameters;
    return p.fields && !p.field_steps.empty() && !p.kinds.empty() && p.split == SplitRule::sensitivity &&
           !gives_lagrangian();
}

Eigen::VectorXd LevelProgram::lagrangian_weights() const {
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(known_.sensitivities.size()));
    weight[objective_gradient_] = sign();
    const Eigen::VectorXd lambda = multipliers(program_, known_.x.cwiseProduct(weight_), known_.sample);
    for (std::size_t i = 0; i < rows_.rows.size(); ++i)
        weight[rows_.rows[i].gradient] +=
            lambda[static_cast<Eigen::Index>(i)] * rows_.rows[i].sign / rows_.rows[i].scale;
    return weight;
}

ShellSensitivities LevelProgram::lagrangian() const {
    std::vector<const ShellSensitivities*> all;
    for (const ShellSensitivities& one : known_.sensitivities) all.push_back(&one);
    Eigen::VectorXd weight = lagrangian_weights();
    const Eigen::VectorXd limits = limit_multipliers(known_.sample);
    for (Eigen::Index i = 0; i < limits.size(); ++i) {
        if (!(limits[i] > 0)) continue;
        all.push_back(&known_.motion.sensitivities[static_cast<std::size_t>(i)]);
        weight.conservativeResize(weight.size() + 1);
        weight[weight.size() - 1] = limits[i];
    }
    ShellSensitivities sum = weighted_sum(all, weight);
    for (Eigen::Index i = 0; i < limits.size(); ++i) {
        const MotionLimit::Row& row = known_.motion.rows[static_cast<std::size_t>(i)];
        if (limits[i] > 0 && known_.motion.sensitivities[static_cast<std::size_t>(i)].vertex.rows() == 0)
            sum.vertex.row(row.vertex) += limits[i] * (row.direction / state_.evaluator.motion_limit().reference());
    }
    return sum;
}

}  // namespace strake
