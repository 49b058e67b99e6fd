#include "core/error.hpp"
#include "optimize/answer_cache.hpp"
#include "optimize/evaluation.hpp"
#include "optimize/journal.hpp"
#include "optimize/own_variables.hpp"

#include <chrono>

/// How a ShapeEvaluator asks the quantities: values first, gradients with them or later.
namespace strake {
namespace {

std::vector<double> numbers(const std::vector<std::pair<std::string, double>>& named) {
    std::vector<double> all;
    for (const auto& [name, value] : named) all.push_back(value);
    return all;
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

/// What a program gave is kept before anything else happens: a run that dies pays for nothing twice.
QuantityResult ShapeEvaluator::call(const Quantity& quantity, const QuantityRequest& request) const {
    if (quantity.program.empty()) return quantity.evaluate(request);
    const std::string& name = quantity.names[0];
    if (journal_) {
        if (auto known = journal_->find_call(request.evaluation, name)) {
            if (known->surface != request.surface_hash)
                throw ReplayMismatch(text("evaluation ", request.evaluation, ": the surface that ", name,
                                          " was given is not the recorded one, bit by bit: another machine, another "
                                          "version of Strake or of its libraries, or another surface file"));
            return std::move(known->result);
        }
    }
    const auto begin = std::chrono::steady_clock::now();
    JournalCall made{request.evaluation, name, content_hash(quantity.program), request.surface_hash, {}, 0};
    made.result = quantity.cache.empty() ? quantity.evaluate(request) : cached_answer(quantity, request);
    made.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    // A failure that ends the run is no answer: the next start asks again.
    if (journal_ && (!made.result.failure || quantity.failing_shortens_step)) journal_->add(made);
    return std::move(made.result);
}

std::shared_ptr<const DesignCalls::Facts> ShapeEvaluator::facts_of(const Eigen::VectorXd& x, int number,
                                                                   const Points& vertices) const {
    auto facts = std::make_shared<DesignCalls::Facts>();
    facts->surface = with_vertices(rest_->surface, vertices);
    const bool is_cached = std::any_of(problem_.quantities.begin(), problem_.quantities.end(),
                                       [](const Quantity& q) { return !q.cache.empty(); });
    if (journal_ || is_cached) facts->hash = content_hash(facts->surface);
    facts->number = number;
    facts->level = space_.level;
    facts->variables = physical_values(space_, x);
    facts->own = own_values(space_, x);
    facts->stop_wanted = stop_wanted_;
    return facts;
}

/// @param quantities the problem's, or `gradient_calls_`.
std::unique_ptr<DesignCalls> ShapeEvaluator::calls_of(const std::vector<Quantity>& quantities,
                                                      std::shared_ptr<const DesignCalls::Facts> facts) const {
    std::vector<char> gradients;
    std::vector<std::vector<char>> wanted;
    for (std::size_t q = 0; q < quantities.size(); ++q) {
        wanted.push_back(wanted_of(q));
        gradients.push_back(&quantities == &gradient_calls_ || (wants_gradients_of(q) && !are_gradients_apart(q)));
    }
    return std::make_unique<DesignCalls>(
        quantities, std::move(facts), std::move(gradients), std::move(wanted),
        [this](const Quantity& quantity, const QuantityRequest& request) { return call(quantity, request); });
}

/// A program is asked for gradients only if one of its values needs them.
bool ShapeEvaluator::wants_gradients_of(std::size_t quantity) const {
    int first = 0;
    for (std::size_t q = 0; q < quantity; ++q) first += static_cast<int>(problem_.quantities[q].names.size());
    const int next = first + static_cast<int>(problem_.quantities[quantity].names.size());
    return std::any_of(needed_.begin(), needed_.end(), [&](int i) { return first <= i && i < next; });
}

bool ShapeEvaluator::are_gradients_apart(std::size_t quantity) const {
    return problem_.quantities[quantity].differentiate && wants_gradients_of(quantity);
}

void ShapeEvaluator::set_gradient_calls() {
    for (std::size_t q = 0; q < problem_.quantities.size(); ++q) {
        Quantity gradient;
        gradient.evaluate = [](const QuantityRequest&) { return QuantityResult{}; };
        if (are_gradients_apart(q)) {
            gradient = problem_.quantities[q];
            gradient.names[0] += " (gradient)";  // in the journal
            gradient.evaluate = gradient.differentiate;
            gradient.cache_key += std::string("\0gradient", 9);
        }
        gradient_calls_.push_back(std::move(gradient));
    }
}

/// The quantity's answer: values, or gradients alone. What it throws is a failure, too. Remarks go to `result`, and so
/// does a failure.
QuantityResult ShapeEvaluator::taken(DesignCalls& calls, std::size_t q, bool wants_values,
                                     ShapeEvaluation& result) const {
    const Quantity& quantity = problem_.quantities[q];
    const std::size_t values = quantity.names.size();
    QuantityResult measured = or_failure([&] { return calls.take(q); });
    result.remarks.insert(result.remarks.end(), measured.remarks.begin(), measured.remarks.end());
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

std::vector<char> ShapeEvaluator::wanted_of(std::size_t quantity) const {
    int first = 0;
    for (std::size_t q = 0; q < quantity; ++q) first += static_cast<int>(problem_.quantities[q].names.size());
    std::vector<char> wanted(problem_.quantities[quantity].names.size(), 0);
    for (const int i : needed_)
        if (i >= first && i - first < static_cast<int>(wanted.size())) wanted[static_cast<std::size_t>(i - first)] = 1;
    return wanted;
}

/// The value of a combination; where it is not finite (a formula's logarithm of a negative number) the step is too far.
bool ShapeEvaluator::combine(const Quantity& quantity, const std::vector<double>& own, ShapeEvaluation& result) {
    Measured& m = last_measured_;
    const double value = combinations_.value(static_cast<int>(m.values.size()), m.values, own);
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

void ShapeEvaluator::measure(Design& design) {
    ShapeEvaluation& result = design.result;
    Measured& m = last_measured_;
    m = {};
    m.own = design.x.tail(space_.num_own());
    const std::vector<double> own = numbers(design.calls->facts()->own);
    for (std::size_t q = 0; q < problem_.quantities.size(); ++q) {
        if (problem_.quantities[q].combination) {
            if (!combine(problem_.quantities[q], own, result)) return;
            continue;
        }
        m.has_gradients_to_come |= are_gradients_apart(q);
        QuantityResult measured = taken(*design.calls, q, true, result);
        if (measured.failure) return;
        m.values.insert(m.values.end(), measured.values.begin(), measured.values.end());
        m.known_dJ_dv.insert(m.known_dJ_dv.end(), measured.dJ_dv.begin(), measured.dJ_dv.end());
        m.known_dJ_down.insert(m.known_dJ_down.end(), measured.dJ_down.begin(), measured.dJ_down.end());
    }
    m.facts = design.calls->facts();
    result.values = m.values;
    result.has_gradients_to_come = m.has_gradients_to_come;
    if (m.has_gradients_to_come || take_gradients(result)) result.status = EvaluationStatus::ok;
}

/// Of the shape whose values the last evaluation gave, maybe that of an earlier one.
bool ShapeEvaluator::ask_for_gradients(ShapeEvaluation& result) {
    Measured& m = last_measured_;
    forget_expected(m.facts->number + 1);
    Design design;
    design.calls = calls_of(gradient_calls_, m.facts);
    if (parallel_ > 1) {
        ahead_.push_back(std::move(design));
        design = take_first();
    }
    int first = 0;
    for (std::size_t q = 0; q < problem_.quantities.size(); ++q) {
        const int count = static_cast<int>(problem_.quantities[q].names.size());
        if (are_gradients_apart(q)) {
            QuantityResult found = taken(*design.calls, q, false, result);
            if (found.failure) return false;
            std::move(found.dJ_dv.begin(), found.dJ_dv.end(), m.known_dJ_dv.begin() + first);
            std::move(found.dJ_down.begin(), found.dJ_down.end(), m.known_dJ_down.begin() + first);
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
    combinations_.differentiate(needed_, m.values, numbers(m.facts->own), m.known_dJ_dv, m.known_dJ_down);
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
    for (std::size_t q = 0; q < problem_.quantities.size(); ++q) {
        const Quantity& quantity = problem_.quantities[q];
        const int next = first + static_cast<int>(quantity.names.size());
        std::optional<QuantityResult> known;
        for (std::size_t i = 0; i < differentiated_.size(); ++i) {
            if (differentiated_[i] < first || differentiated_[i] >= next) continue;
            if (!quantity.program.empty() || quantity.combination) return {};
            if (!known)
                known = or_failure([&] {
                    return quantity.evaluate(
                        {surface, true, 0, space_.level, {}, {}, stop_wanted_, {}, {}, wanted_of(q)});
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
