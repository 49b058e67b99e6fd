#include "cli/progress.hpp"

#include "cli/check_facts.hpp"
#include "cli/say.hpp"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>

namespace strake::cli {
namespace {

constexpr std::size_t rated = 10;  ///< evaluations that the rate is averaged over
constexpr double silent = 3;       ///< seconds after which the bar shows how long the evaluation has been running

/// The rest, for example the end of a program's log, is in the final message.
std::string first_line(const std::string& words) { return words.substr(0, words.find('\n')); }

std::string bar_of(double share, int width) {
    const int full = static_cast<int>(std::clamp(share, 0.0, 1.0) * width);
    return "[" + std::string(static_cast<std::size_t>(full), '#') +
           std::string(static_cast<std::size_t>(width - full), '-') + "]";
}

std::string time_left(const ProgressFacts& f) {
    const int left = f.max_evaluations - f.evaluations;
    if (!std::isfinite(f.seconds_each) || left < 0) return "";
    double seconds = left * f.seconds_each;
    if (std::isfinite(f.seconds_left)) seconds = std::min(seconds, f.seconds_left);
    return fmt::format("at most {} left", duration_words(seconds));
}

}  // namespace

std::string progress_line(const ProgressFacts& f, int width) {
    const double share = f.max_evaluations > 0 ? static_cast<double>(f.evaluations) / f.max_evaluations : 0;
    // In display order; parts with the smallest `keep` are dropped first.
    struct Part {
        std::string words;
        int keep;
    };
    std::vector<Part> parts{{bar_of(share, 20), 5}, {fmt::format("{}/{}", f.evaluations, f.max_evaluations), 9}};
    if (f.level > 0) parts.push_back({fmt::format("level {}", f.level), 8});
    if (f.patches > 0) parts.push_back({fmt::format("{} patches, {} variables", f.patches, f.variables), 1});
    if (std::isfinite(f.objective)) parts.push_back({fmt::format("now {:.6g}", f.objective), 3});
    if (std::isfinite(f.best)) parts.push_back({fmt::format("best {:.6g}", f.best), 7});
    if (std::isfinite(f.violation)) parts.push_back({fmt::format("violation {:.1e}", f.violation), 4});
    if (std::isfinite(f.seconds_each)) parts.push_back({fmt::format("{} each", duration_words(f.seconds_each)), 2});
    if (const std::string left = time_left(f); !left.empty()) parts.push_back({left, 6});
    if (f.seconds_since >= silent) parts.push_back({fmt::format("since {}", duration_words(f.seconds_since)), 0});
    const auto joined_parts = [&] {
        std::string out;
        for (const Part& part : parts) out += (out.empty() ? "" : "  ") + part.words;
        return out;
    };
    std::string out = joined_parts();
    while (static_cast<int>(out.size()) > width && parts.size() > 1) {
        parts.erase(
            std::min_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.keep < b.keep; }));
        out = joined_parts();
    }
    return out.substr(0, static_cast<std::size_t>(std::max(width, 0)));
}

int terminal_width(int descriptor) {
    const char* kind = std::getenv("TERM");
    if (!::isatty(descriptor) || !kind || !*kind || std::strcmp(kind, "dumb") == 0) return 0;
    struct winsize size {};
    if (::ioctl(descriptor, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
    return size.ws_col;
}

Progress::Progress(bool quiet, bool is_fit, double diagonal, int max_evaluations, double max_seconds)
    : quiet_(quiet), is_fit_(is_fit), diagonal_(diagonal), max_seconds_(max_seconds) {
    facts_.max_evaluations = max_evaluations;
    has_bar_ = !quiet && terminal_width(STDERR_FILENO) > 0;
    if (!has_bar_) return;
    // The ticker takes no signals: they belong to the run's thread.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    ticker_ = std::thread([this] {
        std::unique_lock lock(writing_);
        while (!over_.wait_for(lock, std::chrono::seconds(1), [this] { return is_over_; }))
            if (facts_.level > 0) draw();
    });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

Progress::~Progress() { end(); }

void Progress::end() {
    {
        const std::scoped_lock lock(writing_);
        if (is_over_) return;
        is_over_ = true;
        wipe();
    }
    over_.notify_all();
    if (ticker_.joinable()) ticker_.join();
}

void Progress::wipe() {
    if (!std::exchange(is_drawn_, false)) return;
    say("\r\x1b[K");
    std::fflush(stderr);
}

void Progress::draw() {
    if (!has_bar_ || is_over_) return;
    const int width = terminal_width(STDERR_FILENO);
    if (width <= 1) return;
    const auto now = Clock::now();
    const auto seconds = [](Clock::duration d) { return std::chrono::duration<double>(d).count(); };
    facts_.seconds_since = seconds(now - last_);
    facts_.seconds_each = std::numeric_limits<double>::quiet_NaN();
    if (ends_.size() > 3)
        facts_.seconds_each = seconds(ends_.back() - ends_.front()) / static_cast<double>(ends_.size() - 1);
    if (max_seconds_ > 0) facts_.seconds_left = std::max(0.0, max_seconds_ - seconds(now - begin_));
    say("\r{}\x1b[K", progress_line(facts_, width - 1));
    std::fflush(stderr);
    is_drawn_ = true;
}

void Progress::line(const std::string& words) {
    wipe();
    say("{}\n", words);
    if (facts_.level > 0) draw();
}

void Progress::warning(const std::string& words) {
    const std::scoped_lock lock(writing_);
    line("warning: " + words);
}

void Progress::note(const std::string& words) {
    if (quiet_) return;
    const std::scoped_lock lock(writing_);
    line(words);
}

void Progress::level(const LevelStart& start) {
    const std::scoped_lock lock(writing_);
    facts_.level = start.space.level;
    facts_.patches = static_cast<int>(start.space.patches().patches.size());
    facts_.variables = start.space.size();
    if (quiet_) return;
    if (!std::exchange(has_header_, true))
        line(fmt::format("level  patches  vars  eval  {:>16}  violation  moved     time_s",
                         is_fit_ ? "rms distance" : "objective"));
    draw();
}

void Progress::evaluation(const EvaluationRecord& r) {
    const std::scoped_lock lock(writing_);
    last_ = Clock::now();
    facts_.evaluations = r.evaluation;
    const double shown = is_fit_ ? std::sqrt(r.objective) : r.objective;
    if (r.status == "ok") facts_.objective = shown;
    if (r.accepted) facts_.best = shown, facts_.violation = r.max_violation;
    if (quiet_ || r.is_replayed) return;
    ends_.push_back(last_);
    if (ends_.size() > rated + 1) ends_.pop_front();
    const double seconds = std::chrono::duration<double>(last_ - begin_).count();
    if (r.status == "ok")
        line(fmt::format("{:5}  {:7}  {:4}  {:4}  {:16.9e}  {:9.1e}  {:5.2f} %  {:7.1f}{}", r.level, facts_.patches,
                         facts_.variables, r.evaluation, shown, r.max_violation, 100 * r.max_displacement / diagonal_,
                         seconds, r.accepted ? "  best" : ""));
    else
        line(fmt::format("{:5}  {:7}  {:4}  {:4}  {}: {}", r.level, facts_.patches, facts_.variables, r.evaluation,
                         r.status, first_line(r.reason)));
}

void Progress::level_end(const LevelSummary& s) {
    note(fmt::format("level {}: {} after {} evaluation{}", s.level, first_line(s.stop), s.evaluations,
                     s.evaluations == 1 ? "" : "s"));
}

}  // namespace strake::cli
