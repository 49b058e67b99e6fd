#pragma once
#include "optimize/nlp/sqp/step_model.hpp"

/// Steps of sqp that keep to the side of a border on which evaluations give values. Internal.
namespace strake {

/// Chooses the cut of the step model from what the guard has learned of failures (failure_border.hpp): steps far from
/// the border gain little, steps close to it fail; the one with the largest expected decrease times its probability of
/// a value is taken.
class BorderCut {
public:
    BorderCut(const SqpIterate& now, const HessianModel& hessian, const Merit& merit, StepModel& steps)
        : now_(now), hessian_(hessian), merit_(merit), steps_(steps) {}

    /// Sets the cut of the step model as seen from the present point.
    void update();
    bool is_known() const { return steps_.cut.has_value(); }
    /// Decrease of the merit by the step along the cut, times the probability that it has a value.
    double expected_decrease() const { return expected_decrease_; }

private:
    const SqpIterate& now_;
    const HessianModel& hessian_;
    const Merit& merit_;
    StepModel& steps_;
    double expected_decrease_ = 0;
};

}  // namespace strake
