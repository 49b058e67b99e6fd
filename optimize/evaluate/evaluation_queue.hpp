#pragma once
#include "optimize/evaluate/design_calls.hpp"
#include "optimize/evaluate/shape_evaluation.hpp"

#include <deque>
#include <optional>

/// Designs whose programs run at the same time. Internal to the evaluator.
namespace strake {

class Journal;

/// A design that was begun: deformed, and its quantities asked.
struct QueuedDesign {
    int number = 0;
    Eigen::VectorXd x;
    ShapeEvaluation result;
    std::optional<Poses> poses;          ///< none: there is no shape
    std::unique_ptr<DesignCalls> calls;  ///< none: there is no shape, or its values are taken over
    std::exception_ptr thrown;           ///< by the deformation
    bool is_ready() const { return !calls || calls->is_ready(); }
};

/// Shapes are made one after another, in the order of the designs; their programs are called when one of the allowed
/// concurrent calls is free. Without a program that may run in parallel, every design is finished at once.
class EvaluationQueue {
public:
    using Begin = std::function<QueuedDesign(const Eigen::VectorXd& x, int number)>;

    /// @param begin deforms a design and lays out its calls.
    EvaluationQueue(const std::vector<Quantity>& quantities, Begin begin);
    /// @param stop_wanted asked while programs run; may be empty.
    void keep_calls(Journal* journal, std::function<bool()> stop_wanted) {
        journal_ = journal;
        stop_wanted_ = std::move(stop_wanted);
    }

    /// These designs are asked for next, as the evaluations from `first` on.
    void expect(const std::vector<Eigen::VectorXd>& designs, int first);
    /// The same for a row without a known end: `design(number)` is asked, number by number, when a place is free.
    /// Nothing: none for now.
    void expect(std::function<std::optional<Eigen::VectorXd>(int number)> design, int first);
    /// Cancels all that was begun.
    void clear();
    /// The same, and forgets their recorded calls from this evaluation on: others are asked for.
    void drop_expected(int number);
    /// This design, its calls done; where it was expected, its programs have run already.
    QueuedDesign next(const Eigen::VectorXd& x, int number);
    /// Runs the calls of a design outside of the row. @pre nothing is expected.
    QueuedDesign finish(QueuedDesign design);
    /// Stops all programs. @throws Interrupted, with the jobs that are still pending.
    [[noreturn]] void interrupt();

private:
    QueuedDesign take_first();
    bool begin_expected();
    void ask_for_more();
    void advance();

    const std::vector<Quantity>& quantities_;
    Begin begin_;
    Journal* journal_ = nullptr;
    std::function<bool()> stop_wanted_;
    int parallel_ = 1;  ///< maximum number of designs whose programs run at the same time
    std::deque<std::pair<int, Eigen::VectorXd>> expected_;
    std::function<std::optional<Eigen::VectorXd>(int number)> more_;  ///< what comes behind these
    int next_more_ = 0;
    std::deque<QueuedDesign> ahead_;  ///< begun and not yet asked for, and the one that is
};

}  // namespace strake
