#pragma once
#include "optimize/evaluate/constraints.hpp"
#include "optimize/evaluate/evaluation.hpp"
#include "optimize/nlp/program/nonlinear_program.hpp"

/// The values of a problem as its cheap models give them, for designs that are never evaluated. Internal.
namespace strake {

/// Nothing of the value comes from a program.
bool is_cheap(const Problem& problem, const std::string& value);

/// A problem with cheap models, as a nonlinear program in the variables of a level. Shapes are made by an evaluator of
/// its own: they follow each other, and nothing of them reaches the records of the run.
class CheapProgram {
public:
    /// @param stop_wanted as of the run; may be empty. @throws InvalidInput on unknown names
    CheapProgram(const Problem& problem, std::shared_ptr<const RestFacts> rest, Journal* journal,
                 std::function<bool()> stop_wanted)
        : CheapProgram(make(problem), std::move(rest), journal, std::move(stop_wanted)) {}

    /// What all programs of a level share.
    struct Level {
        const DesignSpace& space;
        const ConstraintRows& rows;  ///< set by the first evaluation of the run: looked at when it has been
        const Eigen::VectorXd& weight;
        std::function<Eigen::VectorXd(const Eigen::VectorXd& y)> unscaled;
        double slack;  ///< of the motion limit
        double difference_step;
        bool tells_limits;  ///< with gradients; `method: model` asks the expensive program
        /// Conditions on steps near x, of what an evaluator knows there.
        std::function<StepLimits(const MotionConditions& motion, const FoldConditions& folds)> limits;
        /// Calls, and keeps what it leaves unfinished.
        std::function<void(const std::function<void()>&)> ask;
    };
    /// With the cheap program of this level in `program.low_fidelity`, whose bounds and metric it has.
    /// @param known names and values at the start of the level, asked once these are known
    void enter(NonlinearProgram& program, const Level& level,
               std::function<std::vector<double>(const std::vector<std::string>& names)> known);

    /// "drag by area_rule", joined by commas.
    std::string words() const;
    int evaluations() const { return evaluations_; }

private:
    struct Value {
        int number = -1;  ///< among the values of the problem
        LowFidelityValue kind = LowFidelityValue::same;
        std::string name, low;  ///< of the value, and of what stands for it
        int index = -1;         ///< of that among the evaluator's values
        int gradient = -1;      ///< among the differentiated ones; -1: none
    };
    /// Formulas of values that have cheap models are those of the models, each moved by a constant to what the value is
    /// at the start.
    using Shifts = std::vector<std::pair<CheapModel, double>>;
    class Maker;

    struct Made {
        std::vector<Value> values;  ///< the objective, then those of the constraints
        std::shared_ptr<Shifts> shifts;
        Problem problem;
        std::vector<std::string> differentiated;
    };
    static Made make(const Problem& problem);
    CheapProgram(Made made, std::shared_ptr<const RestFacts> rest, Journal* journal, std::function<bool()> stop_wanted);

    Evaluation evaluate(const Eigen::VectorXd& y);
    void differentiate(Evaluation& sample);
    Eigen::VectorXd first_scale(const Eigen::VectorXd& start,
                                const std::function<std::vector<double>(const std::vector<std::string>&)>& known);
    Differences differences() const;
    std::vector<LowFidelityValue> kinds() const;
    double sign() const { return problem_.maximize ? -1 : 1; }
    const Value& value_of(const ConstraintRow& row) const;

    std::vector<Value> values_;
    std::shared_ptr<Shifts> shifts_;
    const Problem problem_;  ///< of cheap values
    ShapeEvaluator evaluator_;
    std::optional<Level> level_;
    ShapeEvaluation current_;
    Eigen::VectorXd current_x_;
    int evaluations_ = 0;
    bool is_limited_ = false, knows_shifts_ = false;
};

}  // namespace strake
