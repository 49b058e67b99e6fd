#include "optimize/evaluate/quantity_calls.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "optimize/journal/answer_cache.hpp"
#include "optimize/journal/journal.hpp"
#include "optimize/space/parameters.hpp"

#include <chrono>
#include <cmath>

namespace strake {
namespace {

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

/// "on the surface of evaluation 3 (42 vertices, diagonal 2.5) with alpha = 0.1": what a value was made of.
std::string inputs_words(const DesignCalls::Facts& facts) {
    std::string with;
    for (const auto& [name, value] : facts.parameters) with += text(with.empty() ? " with " : ", ", name, " = ", value);
    return text("on the surface of evaluation ", facts.number, " (", facts.surface.num_vertices(),
                " vertices, diagonal ", box_diagonal(facts.surface), ")", with);
}

}  // namespace

QuantityResult or_failure(const std::function<QuantityResult()>& measure) {
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

QuantityCalls::QuantityCalls(const Problem& problem, std::shared_ptr<const RestFacts> rest,
                             const std::vector<std::string>& differentiated)
    : problem_(problem),
      rest_(std::move(rest)),
      names_(value_names(problem)),
      combinations_(problem.quantities, problem.program_parameters) {
    for (const std::string& name : differentiated) differentiated_.push_back(index_of(name));
    needed_ = combinations_.with_parts(differentiated_);
    set_gradient_calls();
}

int QuantityCalls::index_of(const std::string& name) const {
    const auto at = std::find(names_.begin(), names_.end(), name);
    if (at != names_.end()) return static_cast<int>(at - names_.begin());
    std::string known;
    for (const std::string& other : names_) known += (known.empty() ? "" : ", ") + other;
    throw InvalidInput(text("no quantity is called '", name, "'; there are: ", known));
}

/// What a program gave is kept before anything else happens: a run that dies pays for nothing twice.
QuantityResult QuantityCalls::call(const Quantity& quantity, const QuantityRequest& request) const {
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

std::shared_ptr<const DesignCalls::Facts> QuantityCalls::facts_of(const DesignSpace& space, const Eigen::VectorXd& x,
                                                                  int number, const Points& vertices) const {
    auto facts = std::make_shared<DesignCalls::Facts>();
    facts->surface = with_vertices(rest_->surface, vertices);
    const bool is_cached = std::any_of(problem_.quantities.begin(), problem_.quantities.end(),
                                       [](const Quantity& q) { return !q.cache.empty(); });
    if (journal_ || is_cached) facts->hash = content_hash(facts->surface);
    facts->number = number;
    facts->level = space.level;
    facts->variables = physical_values(space, x);
    facts->parameters = parameter_values(space, x);
    facts->stop_wanted = stop_wanted_;
    return facts;
}

/// @param quantities the problem's, or `gradient_calls_`.
std::unique_ptr<DesignCalls> QuantityCalls::calls_of(const std::vector<Quantity>& quantities,
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

std::unique_ptr<DesignCalls> QuantityCalls::value_calls(std::shared_ptr<const DesignCalls::Facts> facts) const {
    return calls_of(problem_.quantities, std::move(facts));
}

std::unique_ptr<DesignCalls> QuantityCalls::gradient_calls(std::shared_ptr<const DesignCalls::Facts> facts) const {
    return calls_of(gradient_calls_, std::move(facts));
}

/// A program is asked for gradients only if one of its values needs them.
bool QuantityCalls::wants_gradients_of(std::size_t quantity) const {
    int first = 0;
    for (std::size_t q = 0; q < quantity; ++q) first += static_cast<int>(problem_.quantities[q].names.size());
    const int next = first + static_cast<int>(problem_.quantities[quantity].names.size());
    return std::any_of(needed_.begin(), needed_.end(), [&](int i) { return first <= i && i < next; });
}

bool QuantityCalls::are_gradients_apart(std::size_t quantity) const {
    return problem_.quantities[quantity].differentiate && wants_gradients_of(quantity);
}

void QuantityCalls::set_gradient_calls() {
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

QuantityResult QuantityCalls::take(DesignCalls& calls, std::size_t q, bool wants_values,
                                   ShapeEvaluation& result) const {
    const Quantity& quantity = problem_.quantities[q];
    const std::size_t values = quantity.names.size();
    QuantityResult measured = or_failure([&] { return calls.take(q); });
    result.remarks.insert(result.remarks.end(), measured.remarks.begin(), measured.remarks.end());
    if (!measured.failure && wants_values && measured.values.size() != values)
        measured.failure = Failure{"wrong_count", text(measured.values.size(), " values, expected ", values, " (",
                                                       quantity.names[0], ", ...)")};
    for (std::size_t i = 0; i < measured.values.size() && !measured.failure; ++i)
        if (!std::isfinite(measured.values[i]))
            measured.failure =
                Failure{"not_finite", text(quantity.names[i], " = ",
                                           (std::isnan(measured.values[i]) ? "nan" : text(measured.values[i])), " ",
                                           inputs_words(*calls.facts()))};
    measured.dJ_dv.resize(values);
    measured.dJ_dp.resize(values);
    if (measured.failure) {
        result.status = EvaluationStatus::quantity_failed;
        result.may_go_on = quantity.failing_shortens_step;
        result.reason = text(quantity.names[0], ": ", measured.failure->kind, ": ", measured.failure->message);
    }
    return measured;
}

std::vector<char> QuantityCalls::wanted_of(std::size_t quantity) const {
    int first = 0;
    for (std::size_t q = 0; q < quantity; ++q) first += static_cast<int>(problem_.quantities[q].names.size());
    std::vector<char> wanted(problem_.quantities[quantity].names.size(), 0);
    for (const int i : needed_)
        if (i >= first && i - first < static_cast<int>(wanted.size())) wanted[static_cast<std::size_t>(i - first)] = 1;
    return wanted;
}

std::optional<Eigen::VectorXd> QuantityCalls::slopes_along(const Points& vertices, const Points& direction,
                                                           int level) const {
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
                    return quantity.evaluate({surface, true, 0, level, {}, {}, stop_wanted_, {}, {}, wanted_of(q)});
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
