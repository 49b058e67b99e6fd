#include "studio/shape_bench.hpp"

#include "casefile/build/build_problem.hpp"
#include "core/error.hpp"
#include "optimize/evaluate/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace strake {
namespace {

bool has_programs(const Case& the_case) {
    return std::any_of(the_case.quantities.begin(), the_case.quantities.end(), [](const QuantityEntry& quantity) {
        return std::holds_alternative<ExternalEntry>(quantity.what);
    });
}

Case without_programs(Case the_case) {
    the_case.start_from.reset();
    the_case.sample.reset();
    if (!has_programs(the_case)) return the_case;
    std::erase_if(the_case.quantities, [](const QuantityEntry& quantity) {
        return std::holds_alternative<ExternalEntry>(quantity.what) ||
               std::holds_alternative<FormulaEntry>(quantity.what);
    });
    the_case.objective = {};
    the_case.fit.clear();
    the_case.constraints.clear();
    the_case.variables.clear();
    return the_case;
}

}  // namespace

struct ShapeBench::Impl {
    bool has_programs;
    BuiltProblem built;
    std::shared_ptr<const RestFacts> rest;
    struct Level {
        DesignSpace space;
        std::vector<BenchVariable> variables;
        /// Keep the shell's analysis from shape to shape. `near` begins at the nearest of the last shapes, which takes
        /// a fraction of the time; `careful` from the datum, by any way that the shell knows, as a sweep does.
        std::unique_ptr<ShapeEvaluator> near = {}, careful = {};
        std::shared_ptr<const LinearPreview> preview = {};
    };
    std::map<int, Level> levels;

    explicit Impl(Case the_case)
        : has_programs(strake::has_programs(the_case)),
          built(build_problem(without_programs(std::move(the_case)), Purpose::any)),
          rest(rest_facts(built.problem)) {}

    Level& level(int number) {
        if (const auto known = levels.find(number); known != levels.end()) return known->second;
        Level made{design_space(rest, number), {}};
        for (int i = 0; i < made.space.size(); ++i) {
            const Variable& variable = made.space.variables[static_cast<std::size_t>(i)];
            made.variables.push_back({variable.name, made.space.lower[i], made.space.upper[i], variable.unit,
                                      variable.kind == VariableKind::parameter});
        }
        return levels.emplace(number, std::move(made)).first->second;
    }

    ShapeEvaluator& evaluator_of(int number, bool is_careful) {
        Level& at = level(number);
        std::unique_ptr<ShapeEvaluator>& evaluator = is_careful ? at.careful : at.near;
        if (!evaluator) {
            evaluator = std::make_unique<ShapeEvaluator>(built.problem, rest, std::vector<std::string>{});
            if (is_careful) evaluator->solve_each_from_datum();
            if (built.problem.parameters.is_limit_stated) evaluator->limit_motion();
            evaluator->enter(at.space);
        }
        return *evaluator;
    }
    /// Nothing: `deformed` wants no more.
    std::optional<ShapeEvaluation> evaluate(int number, bool is_careful, const Eigen::VectorXd& x,
                                            const std::function<bool(const Points&)>& deformed) {
        ShapeEvaluator& evaluator = evaluator_of(number, is_careful);
        if (deformed)
            if (const Points found = evaluator.equilibrium(x); found.rows() > 0 && !deformed(found)) return {};
        return evaluator.evaluate(x, 1);
    }

    /// Value of a quantity and its derivative by the vertices.
    std::pair<double, Points> derivative_of(const std::string& name, const TriMesh& shape, int depth = 0) {
        constexpr int most = 20;
        for (const Quantity& quantity : built.problem.quantities) {
            const auto at = std::find(quantity.names.begin(), quantity.names.end(), name);
            if (at == quantity.names.end()) continue;
            if (quantity.combination) {
                if (depth > most) throw InvalidInput(text("'", name, "' is made of too many others"));
                return of_combination(*quantity.combination, shape, depth);
            }
            QuantityRequest request{shape, true, 1, 0, {}};
            for (const ProgramParameter& parameter : built.problem.program_parameters)
                request.parameters.emplace_back(parameter.name, parameter.start);
            const QuantityResult found = quantity.evaluate(request);
            const auto k = static_cast<std::size_t>(at - quantity.names.begin());
            if (found.failure) throw InvalidInput(found.failure->message);
            if (found.dJ_dv.size() <= k || found.dJ_dv[k].rows() != shape.num_vertices())
                throw InvalidInput(text("'", name, "' gives no derivatives by the vertices"));
            return {found.values[k], found.dJ_dv[k]};
        }
        for (const ProgramParameter& parameter : built.problem.program_parameters)
            if (parameter.name == name) return {parameter.start, Points::Zero(shape.num_vertices(), 3)};
        throw InvalidInput(text("there is no quantity '", name, "'"));
    }
    std::pair<double, Points> of_combination(const Combination& made, const TriMesh& shape, int depth) {
        Eigen::VectorXd values(static_cast<Eigen::Index>(made.of.size())), gradient;
        std::vector<Points> rates;
        for (std::size_t k = 0; k < made.of.size(); ++k) {
            auto [value, rate] = derivative_of(made.of[k], shape, depth + 1);
            values[static_cast<Eigen::Index>(k)] = value;
            rates.push_back(std::move(rate));
        }
        const double value = made.value(values, &gradient);
        Points sum = Points::Zero(shape.num_vertices(), 3);
        for (std::size_t k = 0; k < rates.size(); ++k) sum += gradient[static_cast<Eigen::Index>(k)] * rates[k];
        return {value, sum};
    }
};

ShapeBench::ShapeBench(Case the_case) : impl_(std::make_unique<Impl>(std::move(the_case))) {}
ShapeBench::~ShapeBench() = default;

int ShapeBench::coarsest() const { return coarsest_level(impl_->built.problem.parameters); }
int ShapeBench::finest() const { return static_cast<int>(impl_->built.problem.tree.levels.size()) - 1; }
bool ShapeBench::leaves_out_programs() const { return impl_->has_programs; }

const std::vector<BenchVariable>& ShapeBench::variables(int level) {
    if (level < coarsest() || level > finest())
        throw InvalidInput(text("level ", level, " must be in [", coarsest(), ", ", finest(), "]"));
    return impl_->level(level).variables;
}

BenchShape ShapeBench::at(int level, const std::vector<double>& x, const std::function<bool(const Points&)>& deformed) {
    const std::vector<BenchVariable>& known = variables(level);
    if (x.size() != known.size())
        throw InvalidInput(text(x.size(), " values for the ", known.size(), " variables of level ", level));
    for (std::size_t i = 0; i < x.size(); ++i)
        if (!std::isfinite(x[i]) || x[i] < known[i].lower || x[i] > known[i].upper)
            throw InvalidInput(
                text(known[i].name, " = ", x[i], " must be in [", known[i].lower, ", ", known[i].upper, "]"));
    BenchShape shape;
    const Eigen::VectorXd design = Eigen::VectorXd::Map(x.data(), static_cast<Eigen::Index>(x.size()));
    try {
        shape.names = impl_->evaluator_of(level, false).names();
        std::optional<ShapeEvaluation> found = impl_->evaluate(level, false, design, deformed);
        // Only the careful way refuses: the near one may have ended in another equilibrium.
        if (found && found->status != EvaluationStatus::ok) found = impl_->evaluate(level, true, design, deformed);
        if (!found) {
            shape.status = "overtaken";
            return shape;
        }
        shape.status = to_string(found->status);
        shape.reason = found->reason;
        shape.values = found->values;
        shape.vertices = std::move(found->vertices);
    } catch (const SolverError& error) {
        shape.status = "not_converged";
        shape.reason = error.what();
    }
    return shape;
}

std::shared_ptr<const LinearPreview> ShapeBench::preview(int level) {
    variables(level);
    Impl::Level& at = impl_->level(level);
    if (!at.preview) at.preview = std::make_shared<const LinearPreview>(at.space);
    return at.preview;
}

ShapeBench::Slope ShapeBench::slope(const Points& vertices) {
    const Problem& problem = impl_->built.problem;
    Slope found{problem.objective, "", {}};
    if (problem.objective.empty()) return found;
    if (vertices.rows() != problem.surface.num_vertices())
        throw InvalidInput(text(vertices.rows(), " vertices; the surface has ", problem.surface.num_vertices()));
    TriMesh shape = problem.surface;
    shape.vertices = vertices;
    try {
        found.downhill = (problem.maximize ? 1.0 : -1.0) * impl_->derivative_of(problem.objective, shape).second;
        if (!found.downhill.allFinite()) throw InvalidInput("the derivative is not finite");
    } catch (const InvalidInput& refused) {
        found.trouble = refused.what();
        found.downhill.resize(0, 3);
    }
    return found;
}

}  // namespace strake
