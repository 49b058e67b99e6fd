#include "core/error.hpp"
#include "optimize/evaluation.hpp"
#include "optimize/journal.hpp"

#include <chrono>
#include <thread>

/// Of ShapeEvaluator: running programs for several designs at the same time.
namespace strake {

/// Deforms, and lays out what is to be asked; in parallel the programs are started by `advance`.
ShapeEvaluator::Design ShapeEvaluator::begin(const Eigen::VectorXd& x, int number) {
    Design design;
    design.number = number;
    design.x = x;
    const bool begins = std::exchange(enters_, false);
    try {
        if (!deform(x, design.result)) return design;
    } catch (const Interrupted&) {  // ends the run, not this design
        throw;
    } catch (...) {
        design.thrown = std::current_exception();
        return design;
    }
    design.poses = last_;
    if (!(takes_over_ && begins && take_over(x, design.result))) {
        const auto facts = facts_of(x, number, design.result.vertices);
        if (journal_) design.result.surface = facts->hash;
        design.calls = calls_of(problem_.quantities, facts);
    }
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

/// Others are asked for.
void ShapeEvaluator::forget_expected(int number) {
    const bool was_expected = !ahead_.empty() || !expected_.empty();
    give_up();
    if (was_expected && journal_) journal_->drop_calls_from(number);
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
        forget_expected(number);
        expected_.emplace_back(number, x);
    }
    Design design = take_first();
    if (design.thrown) std::rethrow_exception(design.thrown);
    return design;
}

ShapeEvaluator::Design ShapeEvaluator::take_first() {
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
    return design;
}

}  // namespace strake
