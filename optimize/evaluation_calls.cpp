#include "core/error.hpp"
#include "optimize/answer_cache.hpp"
#include "optimize/evaluation.hpp"
#include "optimize/journal.hpp"
#include "optimize/own_variables.hpp"
#include "optimize/quantity_call.hpp"

#include <chrono>
#include <thread>

/// Of ShapeEvaluator: asking the quantities, and running programs for several designs at the same time.
namespace strake {

/// Deforms, and lays out what is to be asked; in parallel the programs are started by `advance`.
ShapeEvaluator::Design ShapeEvaluator::begin(const Eigen::VectorXd& x, int number) {
    Design design;
    design.number = number;
    design.x = x;
    const bool begins = std::exchange(enters_, false);
    try {
        if (!deform(x, design.result)) return design;
    } catch (...) {
        design.thrown = std::current_exception();
        return design;
    }
    design.poses = last_;
    if (!(takes_over_ && begins && take_over(x, design.result))) design.calls = calls_of(x, number, design.result);
    return design;
}

void ShapeEvaluator::expect(const std::vector<Eigen::VectorXd>& designs, int first) {
    if (parallel_ < 2) return;
    give_up();
    for (const Eigen::VectorXd& x : designs) expected_.emplace_back(first++, x);
}

void ShapeEvaluator::give_up() {
    expected_.clear();
    ahead_.clear();
}

/// One more of the expected designs where a program may be free for it. The shapes of few are kept.
bool ShapeEvaluator::begin_expected() {
    const auto open = std::count_if(ahead_.begin(), ahead_.end(), [](const Design& d) { return !d.is_ready(); });
    if (expected_.empty() || open >= parallel_ || static_cast<int>(ahead_.size()) >= 4 * parallel_) return false;
    ahead_.push_back(begin(expected_.front().second, expected_.front().first));
    expected_.pop_front();
    return true;
}

void ShapeEvaluator::advance() {
    std::vector<int> free;
    for (std::size_t q = 0; q < problem_.quantities.size(); ++q) {
        free.push_back(problem_.quantities[q].parallel);
        for (const Design& design : ahead_) free.back() -= design.calls ? design.calls->occupied(q) : 0;
    }
    for (const Design& design : ahead_)
        if (design.calls) design.calls->advance(free);
}

void ShapeEvaluator::interrupt() {
    Interrupted interrupted;
    for (const Design& design : ahead_) {
        if (!design.calls) continue;
        design.calls->stop(false);
        design.calls->add_going_on(interrupted.going_on);
    }
    give_up();
    throw interrupted;
}

ShapeEvaluator::Design ShapeEvaluator::next(const Eigen::VectorXd& x, int number) {
    if (parallel_ < 2) {
        Design design = begin(x, number);
        if (design.thrown) std::rethrow_exception(design.thrown);
        return design;
    }
    const auto is_asked = [&](int n, const Eigen::VectorXd& other) { return n == number && other == x; };
    const bool is_begun = !ahead_.empty() && is_asked(ahead_.front().number, ahead_.front().x);
    const bool is_expected =
        ahead_.empty() && !expected_.empty() && is_asked(expected_.front().first, expected_.front().second);
    if (!is_begun && !is_expected) {
        const bool was_expected = !ahead_.empty() || !expected_.empty();
        give_up();
        if (was_expected && journal_) journal_->drop_calls_from(number);
        expected_.emplace_back(number, x);
    }
    for (;;) {
        const bool more = begin_expected();
        advance();
        if (ahead_.front().is_ready()) break;
        if (stop_wanted_ && stop_wanted_()) interrupt();
        if (more) continue;
        const bool runs =
            std::any_of(ahead_.begin(), ahead_.end(), [](const Design& d) { return d.calls && d.calls->is_running(); });
        if (!runs && ahead_.front().calls->is_awaited()) {
            if (begin_expected()) continue;  // an answer that came meanwhile has made room
            Awaited all;
            for (const Design& design : ahead_)
                if (design.calls) design.calls->add_awaited(all.calls);
            throw all;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    Design design = std::move(ahead_.front());
    ahead_.pop_front();
    if (design.thrown) std::rethrow_exception(design.thrown);
    return design;
}

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

std::unique_ptr<DesignCalls> ShapeEvaluator::calls_of(const Eigen::VectorXd& x, int number,
                                                      ShapeEvaluation& result) const {
    DesignCalls::Facts facts;
    facts.surface = with_vertices(rest_->surface, result.vertices);
    const bool is_cached = std::any_of(problem_.quantities.begin(), problem_.quantities.end(),
                                       [](const Quantity& q) { return !q.cache.empty(); });
    if (journal_ || is_cached) facts.hash = content_hash(facts.surface);
    if (journal_) result.surface = facts.hash;
    facts.number = number;
    facts.level = space_.level;
    facts.variables = physical_values(space_, x);
    facts.own = own_values(space_, x);
    facts.stop_wanted = stop_wanted_;
    int first = 0;
    for (const Quantity& quantity : problem_.quantities) {
        // A program is asked for gradients only if one of its values needs them.
        const int next = first + static_cast<int>(quantity.names.size());
        facts.gradients.push_back(
            std::any_of(differentiated_.begin(), differentiated_.end(), [&](int i) { return first <= i && i < next; }));
        first = next;
    }
    return std::make_unique<DesignCalls>(
        problem_.quantities, std::move(facts),
        [this](const Quantity& quantity, const QuantityRequest& request) { return call(quantity, request); });
}

void ShapeEvaluator::measure(DesignCalls& calls, ShapeEvaluation& result) const {
    std::vector<Points> dJ_dv;
    std::vector<Eigen::VectorXd> dJ_down;
    for (std::size_t q = 0; q < problem_.quantities.size(); ++q) {
        const Quantity& quantity = problem_.quantities[q];
        QuantityResult measured = or_failure([&] { return calls.take(q); });
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
    take_own_sensitivities(dJ_dv, dJ_down, result);
}

/// The sensitivities of the differentiated values, where they are usable.
void ShapeEvaluator::take_own_sensitivities(std::vector<Points>& dJ_dv, std::vector<Eigen::VectorXd>& dJ_down,
                                            ShapeEvaluation& result) const {
    for (const int i : differentiated_) {
        if (dJ_dv[i].rows() != rest_->surface.num_vertices() || !dJ_dv[i].allFinite()) {
            result.status = EvaluationStatus::quantity_failed;
            result.may_go_on = false;
            result.reason =
                text(names_[i], ": no finite vertex sensitivities (", dJ_dv[i].rows(), " rows for ",
                     rest_->surface.num_vertices(), " vertices); a gradient-free method (cobyla) can do without");
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

}  // namespace strake
