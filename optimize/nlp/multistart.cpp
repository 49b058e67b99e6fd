#include "optimize/nlp/multistart.hpp"

#include "core/error.hpp"
#include "optimize/nlp/minimize_once.hpp"

#include <chrono>
#include <random>

namespace strake {

using Eigen::VectorXd;

namespace {

class Starts {
public:
    Starts(const NonlinearProgram& program, const MinimizeOptions& options) : program_(program), options_(options) {}

    MinimizeResult run() {
        for (int k = 0; k < options_.starts && !is_over_; ++k) one(k);
        best_.evaluations = evaluations_;
        best_.shrinks = shrinks_;
        best_.failures = failures_;
        best_.confirmations = confirmations_;
        if (starts_ > 1) best_.reason += text(" (best of ", starts_, " starts, number ", best_start_ + 1, ")");
        return best_;
    }

private:
    void one(int k) {
        const int left = options_.max_evaluations - evaluations_;
        if (left < 1) return;
        NonlinearProgram program = program_;
        if (k > 0) program.start = random_start(program_, options_.seed, k);
        MinimizeOptions options = options_;
        options.starts = 1;
        options.max_evaluations = std::max(1, left / (options_.starts - k));
        if (options_.max_seconds > 0) {
            options.max_seconds = (options_.max_seconds - (now() - begin_)) / (options_.starts - k);
            if (!(options.max_seconds > 0)) return;
        }
        options.on_step = [&](const MinimizeStep& step) { return report(step); };
        const MinimizeResult r = minimize_once(program, options);
        ++starts_;
        evaluations_ += r.evaluations;
        shrinks_ += r.shrinks;
        failures_ += r.failures;
        confirmations_ += r.confirmations;
        if (k == 0 || is_better(r, best_)) best_ = r, best_start_ = k;
        is_over_ = r.stop == MinimizeStop::stopped || r.best.is_fatal || is_fatal_;
        if (options_.on_event)
            options_.on_event(text("start ", k + 1, " of ", options_.starts, ": ",
                                   std::isfinite(r.best.objective) ? text("objective ", r.best.objective) : "no value",
                                   r.is_feasible ? "" : ", not feasible", " after ", r.evaluations, " evaluations; ",
                                   r.reason));
    }

    double now() const {
        if (options_.clock) return options_.clock();
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    }

    /// Passes the step on with "best" over all starts.
    bool report(const MinimizeStep& step) {
        is_fatal_ |= step.evaluation.is_fatal && !step.evaluation.failure.empty();
        bool is_best = false;
        if (step.is_best) {
            is_best = !has_any_ || (step.is_feasible && !any_feasible_) ||
                      (step.is_feasible == any_feasible_ &&
                       (step.is_feasible ? step.evaluation.objective < objective_ : step.violation < violation_));
            if (is_best) {
                has_any_ = true;
                any_feasible_ = step.is_feasible;
                objective_ = step.evaluation.objective;
                violation_ = step.violation;
            }
        }
        merit_ = std::min(merit_, step.merit);
        if (!options_.on_step) return true;
        return options_.on_step(
            {step.x, step.evaluation, step.violation, is_best, step.is_feasible, merit_, step.penalty});
    }

    const NonlinearProgram& program_;
    const MinimizeOptions& options_;
    MinimizeResult best_;
    int best_start_ = 0, starts_ = 0, evaluations_ = 0, shrinks_ = 0, failures_ = 0, confirmations_ = 0;
    bool is_over_ = false, is_fatal_ = false, has_any_ = false, any_feasible_ = false;
    double objective_ = 0, violation_ = 0, merit_ = std::numeric_limits<double>::infinity();
    double begin_ = now();
};

}  // namespace

bool is_better(const MinimizeResult& a, const MinimizeResult& b) {
    if (!std::isfinite(a.best.objective)) return false;
    if (!std::isfinite(b.best.objective)) return true;
    if (a.is_feasible != b.is_feasible) return a.is_feasible;
    return a.is_feasible ? a.best.objective < b.best.objective : a.violation < b.violation;
}

VectorXd random_start(const NonlinearProgram& p, unsigned seed, int number) {
    std::seed_seq words{seed, static_cast<unsigned>(number)};
    std::mt19937_64 random(words);
    VectorXd x = p.start;
    const bool are_narrower = p.lower_of_starts.size() > 0;
    const VectorXd &lower = are_narrower ? p.lower_of_starts : p.lower,
                   &upper = are_narrower ? p.upper_of_starts : p.upper;
    for (Eigen::Index j = 0; j < x.size(); ++j) {
        // By hand: the standard's distributions differ from library to library.
        const double share = static_cast<double>(random() >> 11) * 0x1.0p-53;
        if (lower[j] < upper[j]) x[j] = lower[j] + share * (upper[j] - lower[j]);
    }
    return x;
}

MinimizeResult minimize_from_starts(const NonlinearProgram& program, const MinimizeOptions& options) {
    return Starts(program, options).run();
}

}  // namespace strake
