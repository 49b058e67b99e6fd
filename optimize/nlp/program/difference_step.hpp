#pragma once
#include "optimize/nlp/program/nonlinear_program.hpp"

/// The step of differences, where values carry noise. Internal.
namespace strake {

struct StepChoice {
    double step = 0;
    double noise = 0;  ///< standard deviation of the value that asks for it
    int value = 0;     ///< 0: the objective; else 1 + the row of a constraint
};

/// After a gradient by differences: one value where the steepest way down leads, a step long. Where the values follow
/// their slopes to half of these, the step is sound. Else four further points on that line give the noise (More & Wild,
/// SIAM J. Sci. Comput. 33, 2011, eq. 2.4: highest divided difference), two to six distant ones the curvature, and
/// 2 sqrt(noise / curvature) is the step with the least error (ACM TOMS 38, 2012, up to their factor 8^(1/4)).
/// None: the present step stays, because it is sound, because a longer one is not better by a factor of two, or
/// because points on the line have no values.
/// @param evaluation at x, differentiated. @param max_step the longest that is allowed.
/// @param evaluate the program's, counted.
std::optional<StepChoice> step_above_noise(const NonlinearProgram& program, const Eigen::VectorXd& x,
                                           const Evaluation& evaluation, double max_step,
                                           const std::function<Evaluation(const Eigen::VectorXd& x)>& evaluate);

/// Standard deviation of the noise of values at t = 0, 1, ..., n - 1 times a step: the root mean square of what their
/// third and higher differences say. A smooth function hardly has any.
double noise_on_even_line(const Eigen::VectorXd& values);

}  // namespace strake
