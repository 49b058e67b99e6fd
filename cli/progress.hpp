#pragma once
#include "optimize/run/run_records.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <thread>

/// What a person sees during a run: lines in a log, and on a terminal a bar below them.
namespace strake::cli {

/// The contents of one progress line.
struct ProgressFacts {
    int level = 0, patches = 0, variables = 0;  ///< 0 patches: not known
    int evaluations = 0, max_evaluations = 0;
    double objective = std::numeric_limits<double>::quiet_NaN(), best = std::numeric_limits<double>::quiet_NaN();
    double violation = std::numeric_limits<double>::quiet_NaN();     ///< of the best design
    double seconds_each = std::numeric_limits<double>::quiet_NaN();  ///< mean of the last ten; NaN: too few
    double seconds_left = std::numeric_limits<double>::quiet_NaN();  ///< until the time limit; NaN: there is none
    double seconds_since = 0;                                        ///< since the last evaluation ended
};

/// One line of at most `width` characters: bar, counts, objective, best, violation, rate and the maximum time left. If
/// the line is too long, the least important parts are dropped. No times before three evaluations are known.
std::string progress_line(const ProgressFacts& facts, int width);

/// Columns of the terminal behind `descriptor`; 0: not a terminal, or a dumb one.
int terminal_width(int descriptor);

class Progress {
public:
    /// @param max_evaluations, max_seconds of the run; 0 seconds: no limit.
    Progress(bool quiet, bool is_fit, double diagonal, int max_evaluations, double max_seconds);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void warning(const std::string& words);
    void note(const std::string& words);
    void level(const LevelStart& start);
    void evaluation(const EvaluationRecord& record);
    void level_end(const LevelSummary& summary);
    /// Removes the bar for good.
    void end();

private:
    using Clock = std::chrono::steady_clock;
    bool quiet_, is_fit_, has_header_ = false;
    double diagonal_, max_seconds_;
    Clock::time_point begin_ = Clock::now(), last_ = begin_;
    std::deque<Clock::time_point> ends_;  ///< of the last evaluations
    ProgressFacts facts_;
    bool has_bar_ = false, is_drawn_ = false;
    std::mutex writing_;
    std::condition_variable over_;
    bool is_over_ = false;
    std::thread ticker_;

    void line(const std::string& words);  ///< above the bar. @pre `writing_` is held
    void draw();                          ///< likewise
    void wipe();
};

}  // namespace strake::cli
