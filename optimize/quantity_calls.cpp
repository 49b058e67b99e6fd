#include "core/error.hpp"
#include "optimize/evaluation.hpp"
#include "optimize/journal.hpp"
#include "optimize/own_variables.hpp"

#include <chrono>

/// How a ShapeEvaluator asks the quantities: values first, gradients with them or later.
namespace strake {
namespace {

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

/// What a program gave is kept before anything else happens: a run that dies pays for nothing twice.
QuantityResult ShapeEvaluator::call(const Quantity& quantity, const Function& function, const std::string& name,
                                    const QuantityRequest& request, const std::string& surface) const {
    if (!journal_ || quantity.program.empty()) return function(request);
    if (auto known = journal_->find_call(request.evaluation, name)) {
        if (known->surface != surface)
            throw ReplayMismatch(text("evaluation ", request.evaluation, ": the surface that ", name,
                                      " was given is not the recorded one, bit by bit: another machine, another "
                                      "version of Strake or of its libraries, or another surface file"));
        return std::move(known->result);
    }
    const auto begin = std::chrono::steady_clock::now();
    JournalCall made{request.evaluation, name, content_hash(quantity.program), surface, {}, 0};
    made.result = function(request);
    made.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    // A failure that ends the run is no answer: the next start asks again.
    if (!made.result.failure || quantity.failing_shortens_step) journal_->add(made);
    return std::move(made.result);
}

/// What a quantity throws is a failure, too; remarks go to `result`, and so does a failure.
QuantityResult ShapeEvaluator::safely(const Quantity& quantity, const Function& function, const std::string& what,
                                      const QuantityRequest& request, ShapeEvaluation& result) const {
    QuantityResult measured = or_failure([&] { return call(quantity, function, what, request, result.surface); });
    result.remarks.insert(result.remarks.end(), measured.remarks.begin(), measured.remarks.end());
    const std::size_t values = quantity.names.size();
    const bool wants_values = what == quantity.names[0];
    if (!measured.failure && wants_values && measured.values.size() != values)
        measured.failure = Failure{"wrong_count", text(measured.values.size(), " values, expected ", values, " (",
                                                       quantity.names[0], ", ...)")};
    for (const double value : measured.values)
        if (!measured.failure && !std::isfinite(value))
            measured.failure = Failure{"not_finite", text(quantity.names[0], ": the value ", value)};
    measured.dJ_dv.resize(values);
    measured.dJ_down.resize(values);
    if (measured.failure) {
        result.status = EvaluationStatus::quantity_failed;
        result.may_go_on = quantity.failing_shortens_step;
        result.reason = text(quantity.names[0], ": ", measured.failure->kind, ": ", measured.failure->message);
    }
    return measured;
}

/// A program is asked for gradients only if one of its values needs them.
bool ShapeEvaluator::wants_gradients_of(int first, const Quantity& quantity) const {
    const int next = first + static_cast<int>(quantity.names.size());
    return std::any_of(needed_.begin(), needed_.end(), [&](int i) { return first <= i && i < next; });
}

std::vector<char> ShapeEvaluator::wanted_of(int first, const Quantity& quantity) const {
    std::vector<char> wanted(quantity.names.size(), 0);
    for (const int i : needed_)
        if (i >= first && i - first < static_cast<int>(wanted.size())) wanted[static_cast<std::size_t>(i - first)] = 1;
    return wanted;
}

/// The value of a combination; where it is not finite (a formula's logarithm of a negative number) the step is too far.
bool ShapeEvaluator::combine(const Quantity& quantity, ShapeEvaluation& result) {
    Measured& m = last_measured_;
    const double value = combinations_.value(static_cast<int>(m.values.size()), m.values, m.own_physical);
    if (!std::isfinite(value)) {
        result.status = EvaluationStatus::quantity_failed;
        result.may_go_on = true;
        result.reason = text(quantity.names[0], ": undefined: the formula gives ", value);
        return false;
    }
    m.values.push_back(value);
    m.known_dJ_dv.emplace_back();
    m.known_dJ_down.emplace_back();
    return true;
}

void ShapeEvaluator::measure(int number, const Eigen::VectorXd& x, ShapeEvaluation& result) {
    const TriMesh surface = with_vertices(rest_->surface, result.vertices);
    if (journal_) result.surface = content_hash(surface);
    Measured& m = last_measured_;
    m = {};
    m.vertices = result.vertices;
    m.own = x.tail(space_.num_own());
    m.at = number;
    m.surface = result.surface;
    for (const auto& [name, value] : own_values(space_, x)) m.own_physical.push_back(value);
    for (const Quantity& quantity : problem_.quantities) {
        if (quantity.combination) {
            if (!combine(quantity, result)) return;
            continue;
        }
        const int first = static_cast<int>(m.values.size());
        const bool gradients = wants_gradients_of(first, quantity);
        const bool later = gradients && quantity.differentiate;
        m.has_gradients_to_come |= later;
        QuantityResult measured =
            safely(quantity, quantity.evaluate, quantity.names[0],
                   {surface, gradients && !later, number, space_.level, physical_values(space_, x),
                    own_values(space_, x), stop_wanted_, wanted_of(first, quantity)},
                   result);
        if (measured.failure) return;
        m.values.insert(m.values.end(), measured.values.begin(), measured.values.end());
        m.known_dJ_dv.insert(m.known_dJ_dv.end(), measured.dJ_dv.begin(), measured.dJ_dv.end());
        m.known_dJ_down.insert(m.known_dJ_down.end(), measured.dJ_down.begin(), measured.dJ_down.end());
    }
    result.values = m.values;
    if (!m.has_gradients_to_come && !take_gradients(result)) return;
    result.has_gradients_to_come = m.has_gradients_to_come;
    result.status = EvaluationStatus::ok;
}

/// Those of the differentiated values, checked, from what the quantities gave.
bool ShapeEvaluator::take_gradients(ShapeEvaluation& result) {
    Measured& m = last_measured_;
    const int n = rest_->surface.num_vertices();
    combinations_.differentiate(needed_, m.values, m.own_physical, m.known_dJ_dv, m.known_dJ_down);
    for (const int i : differentiated_) {
        if (m.known_dJ_dv[i].rows() != n || !m.known_dJ_dv[i].allFinite()) {
            result.status = EvaluationStatus::quantity_failed;
            result.may_go_on = false;
            result.reason = text(names_[i], ": no finite vertex sensitivities (", m.known_dJ_dv[i].rows(), " rows for ",
                                 n, " vertices); a gradient-free method (cobyla) can do without");
            return false;
        }
        if (!own_sensitivities_usable(i, m.known_dJ_down[i], result)) return false;
        m.dJ_dv.push_back(std::move(m.known_dJ_dv[i]));
        m.dJ_down.push_back(std::move(m.known_dJ_down[i]));
    }
    m.known_dJ_dv.clear();
    m.known_dJ_down.clear();
    m.has_gradients_to_come = false;
    result.dJ_dv = m.dJ_dv;
    result.dJ_down = m.dJ_down;
    result.has_gradients_to_come = false;
    return true;
}

/// Of the shape whose values the last evaluation gave, maybe that of an earlier one.
bool ShapeEvaluator::ask_for_gradients(ShapeEvaluation& result) {
    Measured& m = last_measured_;
    const TriMesh surface = with_vertices(rest_->surface, m.vertices);
    const std::string own_surface = std::exchange(result.surface, m.surface);
    int first = 0;
    for (const Quantity& quantity : problem_.quantities) {
        if (quantity.differentiate && wants_gradients_of(first, quantity)) {
            QuantityResult g = safely(quantity, quantity.differentiate, quantity.names[0] + " (gradient)",
                                      {surface, true, m.at, space_.level, physical_values(space_, last_x_),
                                       own_values(space_, last_x_), stop_wanted_, wanted_of(first, quantity)},
                                      result);
            if (g.failure) break;
            for (std::size_t i = 0; i < quantity.names.size(); ++i) {
                m.known_dJ_dv[first + i] = std::move(g.dJ_dv[i]);
                m.known_dJ_down[first + i] = std::move(g.dJ_down[i]);
            }
        }
        first += static_cast<int>(quantity.names.size());
    }
    result.surface = own_surface;
    if (result.status != EvaluationStatus::ok || !take_gradients(result)) return false;
    if (accepted_measured_.at == m.at) accepted_measured_ = m;
    return true;
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

std::optional<Eigen::VectorXd> ShapeEvaluator::slopes_along(const Points& vertices, const Points& direction) const {
    Eigen::VectorXd slopes(static_cast<Eigen::Index>(differentiated_.size()));
    const TriMesh surface = with_vertices(rest_->surface, vertices);
    int first = 0;
    for (const Quantity& quantity : problem_.quantities) {
        const int next = first + static_cast<int>(quantity.names.size());
        std::optional<QuantityResult> known;
        for (std::size_t i = 0; i < differentiated_.size(); ++i) {
            if (differentiated_[i] < first || differentiated_[i] >= next) continue;
            if (!quantity.program.empty() || quantity.combination) return {};
            if (!known)
                known = or_failure([&] {
                    return quantity.evaluate(
                        {surface, true, 0, space_.level, {}, {}, stop_wanted_, wanted_of(first, quantity)});
                });
            if (known->failure) return {};
            slopes[static_cast<Eigen::Index>(i)] =
                known->dJ_dv.at(differentiated_[i] - first).cwiseProduct(direction).sum();
        }
        first = next;
    }
    return slopes;
}

}  // namespace strake
