#include "optimize/evaluate/evaluation_queue.hpp"

#include "optimize/journal/journal.hpp"

#include <chrono>
#include <thread>

namespace strake {

EvaluationQueue::EvaluationQueue(const std::vector<Quantity>& quantities, Begin begin)
    : quantities_(quantities), begin_(std::move(begin)) {
    for (const Quantity& quantity : quantities)
        if (!quantity.program.empty()) parallel_ = std::max(parallel_, quantity.parallel);
}

void EvaluationQueue::expect(const std::vector<Eigen::VectorXd>& designs, int first) {
    if (parallel_ < 2) return;
    clear();
    for (const Eigen::VectorXd& x : designs) expected_.emplace_back(first++, x);
}

void EvaluationQueue::expect(std::function<std::optional<Eigen::VectorXd>(int number)> design, int first) {
    if (parallel_ < 2) return;
    clear();
    more_ = std::move(design);
    next_more_ = first;
}

void EvaluationQueue::ask_for_more() {
    if (!expected_.empty() || !more_) return;
    if (const auto x = more_(next_more_)) expected_.emplace_back(next_more_++, *x);
}

void EvaluationQueue::clear() {
    expected_.clear();
    more_ = {};
    ahead_.clear();
}

void EvaluationQueue::drop_expected(int number) {
    const bool was_expected = !ahead_.empty() || !expected_.empty() || more_;
    clear();
    if (was_expected && journal_) journal_->drop_calls_from(number);
}

/// Begins one more of the expected designs where a program may be free for it. Only a few shapes are kept.
bool EvaluationQueue::begin_expected() {
    const auto open = std::count_if(ahead_.begin(), ahead_.end(), [](const QueuedDesign& d) { return !d.is_ready(); });
    if (open >= parallel_ || static_cast<int>(ahead_.size()) >= 4 * parallel_) return false;
    try {
        ask_for_more();
        if (expected_.empty()) return false;
        ahead_.push_back(begin_(expected_.front().second, expected_.front().first));
    } catch (const Interrupted&) {  // ends the run, not this design
        interrupt();
    }
    expected_.pop_front();
    return true;
}

void EvaluationQueue::advance() {
    std::vector<int> free;
    for (std::size_t q = 0; q < quantities_.size(); ++q) {
        free.push_back(quantities_[q].parallel);
        for (const QueuedDesign& design : ahead_) free.back() -= design.calls ? design.calls->occupied(q) : 0;
    }
    for (const QueuedDesign& design : ahead_)
        if (design.calls) design.calls->advance(free);
}

void EvaluationQueue::interrupt() {
    Interrupted interrupted;
    for (const QueuedDesign& design : ahead_) {
        if (!design.calls) continue;
        design.calls->stop(false);
        design.calls->add_pending(interrupted.pending);
    }
    clear();
    throw interrupted;
}

QueuedDesign EvaluationQueue::next(const Eigen::VectorXd& x, int number) {
    QueuedDesign design;
    if (parallel_ < 2) {
        design = begin_(x, number);
    } else {
        const auto is_asked = [&](int n, const Eigen::VectorXd& other) { return n == number && other == x; };
        if (ahead_.empty()) ask_for_more();
        const bool is_begun = !ahead_.empty() && is_asked(ahead_.front().number, ahead_.front().x);
        const bool is_expected =
            ahead_.empty() && !expected_.empty() && is_asked(expected_.front().first, expected_.front().second);
        if (!is_begun && !is_expected) {
            drop_expected(number);
            expected_.emplace_back(number, x);
        }
        design = take_first();
    }
    if (design.thrown) std::rethrow_exception(design.thrown);
    return design;
}

QueuedDesign EvaluationQueue::finish(QueuedDesign design) {
    if (parallel_ < 2) return design;
    ahead_.push_back(std::move(design));
    return take_first();
}

QueuedDesign EvaluationQueue::take_first() {
    for (;;) {
        const bool more = begin_expected();
        advance();
        if (ahead_.front().is_ready()) break;
        if (stop_wanted_ && stop_wanted_()) interrupt();
        if (more) continue;
        const bool runs = std::any_of(ahead_.begin(), ahead_.end(),
                                      [](const QueuedDesign& d) { return d.calls && d.calls->is_running(); });
        if (!runs && ahead_.front().calls->is_awaited()) {
            if (begin_expected()) continue;  // an answer that came meanwhile has made room
            Awaited all;
            for (const QueuedDesign& design : ahead_)
                if (design.calls) design.calls->add_awaited(all.calls);
            throw all;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    QueuedDesign design = std::move(ahead_.front());
    ahead_.pop_front();
    return design;
}

}  // namespace strake
