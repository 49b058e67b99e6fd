#include "optimize/run/cheap_program.hpp"

#include "core/error.hpp"
#include "optimize/journal/journal_records.hpp"

#include <algorithm>

namespace strake {
namespace {

constexpr double near_limit = 0.6;     ///< vertices that a step may bring to their limit
constexpr double nearly_folded = 0.6;  ///< determinants of triangles that a step may fold
constexpr double largest_scale =
    1e6;  ///< of a value over its cheap one, either way: beyond, one of them is nearly zero

const Quantity* quantity_of(const std::vector<Quantity>& quantities, const std::string& value) {
    for (const Quantity& quantity : quantities)
        if (std::find(quantity.names.begin(), quantity.names.end(), value) != quantity.names.end()) return &quantity;
    return nullptr;
}

}  // namespace

bool is_cheap(const Problem& problem, const std::string& value) {
    const Quantity* quantity = quantity_of(problem.quantities, value);
    if (!quantity) return true;  // a parameter
    if (!quantity->combination) return quantity->program.empty();
    const auto& parts = quantity->combination->of;
    return std::all_of(parts.begin(), parts.end(), [&](const std::string& part) { return is_cheap(problem, part); });
}

/// Puts together the quantities of the cheap problem, parts before what is made of them.
class CheapProgram::Maker {
public:
    Maker(const Problem& problem, Made& made) : problem_(problem), made_(made) {}

    /// What stands for the value, and the quantities that it takes. Nothing: there is none.
    std::optional<std::string> stand_in(const std::string& value) {
        if (is_cheap(problem_, value)) return take(value);
        for (const CheapModel& model : problem_.cheap_models)
            if (model.value == value) return take(model.low);
        const Quantity* quantity = quantity_of(problem_.quantities, value);
        if (!quantity->combination) return {};
        std::vector<std::string> parts;
        for (const std::string& part : quantity->combination->of) {
            const std::optional<std::string> low = stand_in(part);
            if (!low) return {};
            parts.push_back(*low);
        }
        if (quantity_of(quantities(), value)) return value;
        quantities().push_back(formula_of(*quantity, parts));
        return value;
    }

private:
    std::vector<Quantity>& quantities() { return made_.problem.quantities; }

    /// The value as it is, of built-in quantities and of cheap programs; these under names of their own, by which the
    /// journal knows their answers.
    std::string take(const std::string& value) {
        if (const Quantity* program = quantity_of(problem_.cheap_programs, value)) {
            const std::string name = cheap_call + value;
            if (quantity_of(quantities(), name)) return name;
            quantities().push_back(*program);
            for (std::string& each : quantities().back().names) each.insert(0, cheap_call);
            return name;
        }
        const Quantity* quantity = quantity_of(problem_.quantities, value);
        if (!quantity || quantity_of(quantities(), value)) return value;  // a parameter, or there already
        Quantity taken = *quantity;
        if (taken.combination)
            for (std::string& part : taken.combination->of) part = take(part);
        quantities().push_back(std::move(taken));
        return value;
    }

    Quantity formula_of(const Quantity& quantity, const std::vector<std::string>& parts) {
        Quantity made = quantity;
        std::vector<int> shifts;  // per part; -1: none
        made.has_sensitivities = true;
        for (std::size_t k = 0; k < parts.size(); ++k) {
            const std::string& part = quantity.combination->of[k];
            shifts.push_back(parts[k] == part ? -1 : static_cast<int>(made_.shifts->size()));
            if (parts[k] != part) made_.shifts->push_back({{part, parts[k]}, 0.0});
            if (const Quantity* of = quantity_of(quantities(), parts[k]))
                made.has_sensitivities &= of->has_sensitivities;
        }
        made.combination->of = parts;
        made.combination->value = [value = quantity.combination->value, shifts, all = made_.shifts](
                                      const Eigen::VectorXd& at, Eigen::VectorXd* gradient) {
            Eigen::VectorXd moved = at;
            for (std::size_t k = 0; k < shifts.size(); ++k)
                if (shifts[k] >= 0)
                    moved[static_cast<Eigen::Index>(k)] += (*all)[static_cast<std::size_t>(shifts[k])].second;
            return value(moved, gradient);
        };
        return made;
    }

    const Problem& problem_;
    Made& made_;
};

CheapProgram::Made CheapProgram::make(const Problem& problem) {
    Made made;
    made.problem = problem;
    made.problem.quantities.clear();
    made.shifts = std::make_shared<Shifts>();
    std::vector<std::string> names{problem.objective};
    for (const Constraint& c : problem.constraints)
        if (std::find(names.begin(), names.end(), c.quantity) == names.end()) names.push_back(c.quantity);
    Maker maker(problem, made);
    for (const std::string& name : names) {
        Value value;
        value.name = name;
        int number = 0;
        for (const Quantity& quantity : problem.quantities)
            for (const std::string& other : quantity.names) {
                if (other == name) value.number = number;
                ++number;
            }
        const std::optional<std::string> low = maker.stand_in(name);
        value.kind = !low                      ? LowFidelityValue::none
                     : is_cheap(problem, name) ? LowFidelityValue::same
                                               : LowFidelityValue::approximate;
        value.low = low.value_or("");
        if (low && quantity_of(made.problem.quantities, *low)->has_sensitivities &&
            std::find(made.differentiated.begin(), made.differentiated.end(), *low) == made.differentiated.end())
            made.differentiated.push_back(*low);
        made.values.push_back(value);
    }
    return made;
}

CheapProgram::CheapProgram(Made made, std::shared_ptr<const RestFacts> rest, Journal* journal,
                           std::function<bool()> stop_wanted)
    : values_(std::move(made.values)),
      shifts_(std::move(made.shifts)),
      problem_(std::move(made.problem)),
      evaluator_(problem_, std::move(rest), made.differentiated) {
    evaluator_.keep_calls(problem_.cheap_programs.empty() ? nullptr : journal, stop_wanted, false);
    for (Value& value : values_) {
        if (value.kind == LowFidelityValue::none) continue;
        value.index = evaluator_.index_of(value.low);
        const auto at = std::find(made.differentiated.begin(), made.differentiated.end(), value.low);
        if (at != made.differentiated.end()) value.gradient = static_cast<int>(at - made.differentiated.begin());
    }
}

std::string CheapProgram::words() const {
    std::string words;
    for (const CheapModel& model : problem_.cheap_models)
        words += text(words.empty() ? "" : ", ", model.low, " for ", model.value);
    return words;
}

const CheapProgram::Value& CheapProgram::value_of(const ConstraintRow& row) const {
    return *std::find_if(values_.begin(), values_.end(), [&](const Value& v) { return v.number == row.value; });
}

std::vector<LowFidelityValue> CheapProgram::kinds() const {
    std::vector<LowFidelityValue> kinds{values_[0].kind}, equalities;
    const auto kind_of = [&](const std::string& name) {
        return std::find_if(values_.begin(), values_.end(), [&](const Value& v) { return v.name == name; })->kind;
    };
    for (const Constraint& c : problem_.constraints) {
        if (c.min) kinds.push_back(kind_of(c.quantity));
        if (c.max) kinds.push_back(kind_of(c.quantity));
        if (c.equals) equalities.push_back(kind_of(c.quantity));
    }
    kinds.insert(kinds.end(), equalities.begin(), equalities.end());
    return kinds;
}

Differences CheapProgram::differences() const {
    Differences differences;
    differences.step = level_->difference_step;
    const auto needs = [](const Value& v) { return v.kind != LowFidelityValue::none && v.gradient < 0; };
    differences.objective = needs(values_[0]);
    std::vector<char> equalities;
    for (const Constraint& c : problem_.constraints) {
        const auto value =
            std::find_if(values_.begin(), values_.end(), [&](const Value& v) { return v.name == c.quantity; });
        if (c.min) differences.rows.push_back(needs(*value));
        if (c.max) differences.rows.push_back(needs(*value));
        if (c.equals) equalities.push_back(needs(*value));
    }
    differences.rows.insert(differences.rows.end(), equalities.begin(), equalities.end());
    return differences;
}

void CheapProgram::enter(NonlinearProgram& program, const Level& level,
                         std::function<std::vector<double>(const std::vector<std::string>&)> known) {
    level_.emplace(level);
    if (!std::exchange(is_limited_, true)) evaluator_.limit_motion();
    evaluator_.enter(level.space);
    auto cheap = std::make_shared<NonlinearProgram>();
    cheap->start = program.start;
    cheap->lower = program.lower;
    cheap->upper = program.upper;
    cheap->metric = program.metric;
    cheap->num_inequalities = program.num_inequalities;
    cheap->num_equalities = program.num_equalities;
    cheap->evaluate = [this](const Eigen::VectorXd& y) { return evaluate(y); };
    cheap->differentiate = [this](const Eigen::VectorXd&, Evaluation& sample) { differentiate(sample); };
    const bool needs_differences = std::any_of(values_.begin(), values_.end(), [](const Value& v) {
        return v.kind != LowFidelityValue::none && v.gradient < 0;
    });
    if (needs_differences) {
        cheap->differences = differences();
        cheap->expect = [this](const std::vector<Eigen::VectorXd>& points) {
            std::vector<Eigen::VectorXd> designs;
            for (const Eigen::VectorXd& y : points) designs.push_back(level_->unscaled(y));
            evaluator_.expect(designs, evaluations_ + 1);
        };
    }
    if (!evaluator_.motion_limit().is_none()) {
        cheap->within = [this](const Eigen::VectorXd& y) {
            const Eigen::VectorXd x = level_->unscaled(y),
                                  inside = evaluator_.within(x, level_->slack, EdgeFolds::kept);
            return inside == x ? y : Eigen::VectorXd(inside.cwiseProduct(level_->weight));
        };
        cheap->beyond = [this](const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
            const Eigen::VectorXd x0 = level_->unscaled(from), x = level_->unscaled(to);
            if (!evaluator_.is_beyond(x, level_->slack)) return StepLimits();
            const MotionConditions motion = evaluator_.motion_conditions(x, 1 - 2 * level_->slack);
            return level_->limits(on_steps(motion, x - x0), evaluator_.fold_conditions_between(x0, x));
        };
    }
    program.low_fidelity = LowFidelity{std::move(cheap), kinds(),
                                       [this, start = program.start, known] { return first_scale(start, known); }};
}

Eigen::VectorXd CheapProgram::first_scale(
    const Eigen::VectorXd& start, const std::function<std::vector<double>(const std::vector<std::string>&)>& known) {
    const Evaluation at_start = evaluate(start);
    const auto value_at = [&](const std::string& name) {
        return current_.values[static_cast<std::size_t>(evaluator_.index_of(name))];
    };
    const auto known_value = [&](const std::string& name) { return known({name})[0]; };
    if (at_start.failure.empty() && !knows_shifts_)
        for (auto& [model, shift] : *shifts_) shift = known_value(model.value) - value_at(model.low);
    knows_shifts_ = knows_shifts_ || at_start.failure.empty();
    const auto scale_of = [&](const Value& v) {
        // Where formulas are moved their values say nothing of the scale.
        const bool is_moved = v.name == v.low;
        if (v.kind != LowFidelityValue::approximate || is_moved || !at_start.failure.empty()) return 1.0;
        const double scale = known_value(v.name) / value_at(v.low), size = std::abs(scale);
        return size < largest_scale && size > 1 / largest_scale ? scale : 1.0;
    };
    const std::vector<ConstraintRow>& rows = level_->rows.rows;
    Eigen::VectorXd scales(1 + static_cast<Eigen::Index>(rows.size()));
    scales[0] = scale_of(values_[0]);
    for (std::size_t i = 0; i < rows.size(); ++i)
        scales[1 + static_cast<Eigen::Index>(i)] = scale_of(value_of(rows[i]));
    return scales;
}

Evaluation CheapProgram::evaluate(const Eigen::VectorXd& y) {
    Evaluation sample;
    current_x_ = level_->unscaled(y);
    level_->ask([&] { current_ = evaluator_.evaluate(current_x_, ++evaluations_); });
    if (current_.status != EvaluationStatus::ok) {
        sample.failure = current_.reason;
        sample.is_of_step =
            current_.status == EvaluationStatus::not_converged || current_.status == EvaluationStatus::unstable;
        return sample;
    }
    const auto value_at = [&](const Value& v) {
        return v.index < 0 ? 0.0 : current_.values[static_cast<std::size_t>(v.index)];
    };
    sample.objective = sign() * value_at(values_[0]);
    const std::vector<ConstraintRow>& rows = level_->rows.rows;
    sample.constraints = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Value& value = value_of(rows[i]);
        if (value.index >= 0) sample.constraints[static_cast<Eigen::Index>(i)] = rows[i].of(value_at(value));
    }
    return sample;
}

void CheapProgram::differentiate(Evaluation& sample) {
    if (current_.has_gradients_to_come || !current_.dJ_dv.empty())
        level_->ask([&] { evaluator_.differentiate(current_); });
    if (current_.status != EvaluationStatus::ok) {
        sample.failure = current_.reason;
        return;
    }
    const Eigen::VectorXd inverse = level_->weight.cwiseInverse();
    const auto gradient_of = [&](const Value& v) -> Eigen::VectorXd {
        if (v.gradient < 0) return Eigen::VectorXd::Zero(inverse.size());
        return current_.gradients.row(v.gradient).transpose().cwiseProduct(inverse);
    };
    sample.gradient = sign() * gradient_of(values_[0]);
    const std::vector<ConstraintRow>& rows = level_->rows.rows;
    sample.jacobian.resize(static_cast<Eigen::Index>(rows.size()), inverse.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
        sample.jacobian.row(static_cast<Eigen::Index>(i)) =
            rows[i].sign / rows[i].scale * gradient_of(value_of(rows[i])).transpose();
    if (level_->tells_limits)
        sample.limits = level_->limits(on_steps(evaluator_.motion_conditions(current_x_, near_limit)),
                                       evaluator_.fold_conditions(current_x_, nearly_folded));
    evaluator_.accept();  // the next shape is made from here
}

}  // namespace strake
