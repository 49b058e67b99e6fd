#include "optimize/check/sweep.hpp"

#include "core/error.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/least_squares/fit_residuals.hpp"

namespace strake {
namespace {

constexpr int shown_names = 12;

int variable_named(const DesignSpace& space, const std::string& name) {
    std::string known;
    for (int i = 0; i < space.size(); ++i) {
        const int j = (space.num_shape() + i) % space.size();  // parameters first
        if (space.variables[j].name == name) return j;
        if (i < shown_names) known += (known.empty() ? "" : ", ") + space.variables[j].name;
    }
    if (space.size() > shown_names) known += text(" and ", space.size() - shown_names, " more");
    throw InvalidInput(text("sweep: no variable of level ", space.level, " is called '", name,
                            "'; there are: ", known.empty() ? "none" : known));
}

void validate(const SweepOptions& options, const Problem& problem) {
    if (options.axes.empty()) throw InvalidInput("sweep: no variable is named");
    const int finest = static_cast<int>(problem.tree.levels.size()) - 1;
    const int coarsest = coarsest_level(problem.parameters);
    if (options.level < coarsest || options.level > finest)
        throw InvalidInput(text("sweep: level ", options.level, " must be in [", coarsest, ", ", finest, "]"));
    double points = 1;
    for (std::size_t i = 0; i < options.axes.size(); ++i) {
        const SweepAxis& axis = options.axes[i];
        if (!std::isfinite(axis.from) || !std::isfinite(axis.to))
            throw InvalidInput(
                text("sweep: the range of '", axis.variable, "', ", axis.from, " to ", axis.to, ", must be finite"));
        if (axis.steps < 1) throw InvalidInput(text("sweep: steps = ", axis.steps, " must be >= 1"));
        for (std::size_t k = 0; k < i; ++k)
            if (options.axes[k].variable == axis.variable)
                throw InvalidInput(text("sweep: '", axis.variable, "' is named twice"));
        points *= axis.steps;
    }
    if (points > max_sweep_points) throw InvalidInput(text("sweep: ", points, " points; at most ", max_sweep_points));
}

double place(const SweepAxis& axis, int k) {
    if (k == axis.steps - 1 && k > 0) return axis.to;
    return k == 0 ? axis.from : axis.from + (axis.to - axis.from) * k / (axis.steps - 1);
}

class Sweeper {
public:
    Sweeper(const Problem& problem, const SweepOptions& options)
        : problem_(problem), rest_(rest_facts(problem)), space_(design_space(rest_, options.level)) {
        if (!problem.fit.empty()) residuals_.emplace(problem);
        for (const SweepAxis& axis : options.axes) {
            variables_.push_back(variable_named(space_, axis.variable));
            check_bounds(axis);
        }
    }

    std::vector<std::string> names() const { return ShapeEvaluator(problem_, rest_, {}).names(); }

    SweepPoint at(const std::vector<double>& place, int number) {
        Eigen::VectorXd x = Eigen::VectorXd::Zero(space_.size());
        SweepPoint point{.x = place, .physical = {}, .status = "", .reason = "", .values = {}};
        for (std::size_t i = 0; i < place.size(); ++i) {
            const Variable& variable = space_.variables[variables_[i]];
            const bool is_own = variable.kind == VariableKind::parameter;
            x[variables_[i]] = is_own ? (place[i] - variable.offset) / variable.unit : place[i];
            point.x[i] = x[variables_[i]];
            point.physical.push_back(is_own ? place[i] : place[i] * variable.unit);
        }
        ShapeEvaluator evaluator(problem_, rest_, {});  // a new one: it would go on from where the last point ended
        if (problem_.parameters.is_limit_stated) evaluator.limit_motion();
        evaluator.enter(space_);
        try {
            ShapeEvaluation shape = evaluator.evaluate(x, number);
            point.status = to_string(shape.status);
            point.reason = shape.reason;
            point.values = shape.values;
            if (shape.status == EvaluationStatus::ok) set_objective(evaluator, shape, point);
        } catch (const SolverError& error) {
            point.status = to_string(EvaluationStatus::not_converged);
            point.reason = error.what();
        }
        return point;
    }

private:
    const Problem& problem_;
    std::shared_ptr<const RestFacts> rest_;
    DesignSpace space_;
    std::optional<FitResiduals> residuals_;
    std::vector<int> variables_;  ///< of the axes

    /// Quantities are never asked for values of parameters that the case does not allow.
    void check_bounds(const SweepAxis& axis) const {
        for (const ProgramParameter& own : rest_->program_parameters)
            for (const double value : {axis.from, axis.to})
                if (own.name == axis.variable && !(value >= own.min && value <= own.max))
                    throw InvalidInput(text("sweep: ", own.name, " = ", value, " must be in [", own.min, ", ", own.max,
                                            "]", own.is_angle ? " (radians)" : ""));
    }

    void set_objective(const ShapeEvaluator& evaluator, const ShapeEvaluation& shape, SweepPoint& point) {
        if (!problem_.objective.empty()) point.objective = shape.values[evaluator.index_of(problem_.objective)];
        if (!residuals_) return;
        try {
            const TriMesh surface = with_vertices(rest_->surface, shape.vertices);
            point.objective = residuals_->at(surface, surface).r.squaredNorm();
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            point.status = to_string(EvaluationStatus::quantity_failed);
            point.reason = error.what();
            point.values.clear();
        }
    }
};

}  // namespace

Sweep sweep(const Problem& problem, const SweepOptions& options, const std::function<void(const SweepPoint&)>& each) {
    validate(options, problem);
    Sweeper sweeper(problem, options);
    Sweep result{sweeper.names(), {}};
    std::vector<int> index(options.axes.size(), 0);
    while (true) {
        std::vector<double> x;
        for (std::size_t i = 0; i < index.size(); ++i) x.push_back(place(options.axes[i], index[i]));
        result.points.push_back(sweeper.at(x, static_cast<int>(result.points.size()) + 1));
        if (each) each(result.points.back());
        int i = static_cast<int>(index.size()) - 1;
        while (i >= 0 && ++index[i] == options.axes[i].steps) index[i--] = 0;
        if (i < 0) return result;
    }
}

}  // namespace strake
