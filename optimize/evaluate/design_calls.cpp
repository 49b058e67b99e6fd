#include "optimize/evaluate/design_calls.hpp"

#include <chrono>

namespace strake {

DesignCalls::DesignCalls(const std::vector<Quantity>& quantities, std::shared_ptr<const Facts> facts,
                         std::vector<char> gradients, std::vector<std::vector<char>> wanted, Maker make)
    : quantities_(quantities),
      facts_(std::move(facts)),
      gradients_(std::move(gradients)),
      wanted_(std::move(wanted)),
      make_(std::move(make)),
      calls_(quantities.size()) {}

DesignCalls::~DesignCalls() { stop(true); }

QuantityRequest DesignCalls::request(std::size_t q) const {
    const Facts& f = *facts_;
    return {f.surface,    gradients_[q] != 0, f.number, f.level, f.variables,
            f.parameters, f.stop_wanted,      {},       f.hash,  wanted_[q]};
}

void DesignCalls::run(std::size_t q, Call& call) {
    try {
        call.result = make_(quantities_[q], request(q));
    } catch (...) {
        call.thrown = std::current_exception();
    }
    call.state = State::done;
}

void DesignCalls::collect(Call& call) {
    call.state = State::done;
    try {
        call.result = call.future.get();
    } catch (const Awaited&) {
        call.thrown = std::current_exception();
        call.state = State::awaited;
    } catch (...) {
        call.thrown = std::current_exception();
    }
}

void DesignCalls::advance(std::vector<int>& free) {
    for (std::size_t q = 0; q < calls_.size(); ++q) {
        Call& call = calls_[q];
        const bool is_program = !quantities_[q].program.empty();
        if (call.state == State::none && !is_program) run(q, call);
        if (call.state == State::none && free[q] > 0) {
            --free[q];
            QuantityRequest asked = request(q);
            asked.stop_wanted = [stop = stop_] { return stop->wanted.load(); };
            asked.is_cancelled = [stop = stop_] { return stop->cancelled.load(); };
            call.future = std::async(std::launch::async,
                                     [this, q, asked = std::move(asked)] { return make_(quantities_[q], asked); });
            call.state = State::running;
        }
        if (call.state == State::running && call.future.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
            collect(call);
        if (call.state == State::done && call.has_failed()) return end(q + 1, true);
    }
}

void DesignCalls::end(std::size_t first, bool cancelled) {
    bool any = false;
    for (std::size_t q = first; q < calls_.size(); ++q) any |= calls_[q].state == State::running;
    if (!any) return;
    stop_->cancelled = cancelled;
    stop_->wanted = true;
    for (std::size_t q = first; q < calls_.size(); ++q)
        if (calls_[q].state == State::running) collect(calls_[q]);
}

void DesignCalls::stop(bool cancelled) { end(0, cancelled); }

bool DesignCalls::is_ready() const {
    for (const Call& call : calls_) {
        if (call.state != State::done) return false;
        if (call.has_failed()) return true;
    }
    return true;
}

bool DesignCalls::is_running() const {
    return std::any_of(calls_.begin(), calls_.end(), [](const Call& c) { return c.state == State::running; });
}

bool DesignCalls::is_awaited() const {
    return std::any_of(calls_.begin(), calls_.end(), [](const Call& c) { return c.state == State::awaited; });
}

int DesignCalls::occupied(std::size_t q) const {
    return calls_[q].state == State::running || calls_[q].state == State::awaited ? 1 : 0;
}

void DesignCalls::add_pending(std::vector<std::string>& jobs) const {
    for (const Call& call : calls_) {
        if (!call.thrown) continue;
        try {
            std::rethrow_exception(call.thrown);
        } catch (const Interrupted& interrupted) {
            jobs.insert(jobs.end(), interrupted.pending.begin(), interrupted.pending.end());
        } catch (...) {  // reported when it is taken
        }
    }
}

void DesignCalls::add_awaited(std::vector<AwaitedCall>& calls) const {
    for (const Call& call : calls_) {
        if (call.state != State::awaited) continue;
        try {
            std::rethrow_exception(call.thrown);
        } catch (const Awaited& awaited) {
            calls.insert(calls.end(), awaited.calls.begin(), awaited.calls.end());
        }
    }
}

QuantityResult DesignCalls::take(std::size_t q) {
    Call& call = calls_[q];
    if (call.state == State::none) run(q, call);
    if (call.thrown) std::rethrow_exception(call.thrown);
    return std::move(call.result);
}

}  // namespace strake
