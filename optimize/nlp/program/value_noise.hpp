#pragma once
#include <Eigen/Core>
#include <vector>

/// The noise of computed values: what rounding, unconverged solvers and discretization add to a smooth function. Nobody
/// else estimates it: difference steps, verdicts and stopping rules ask here.
namespace strake {

/// Standard deviation of the noise of values on a line, from their highest divided difference: a smooth part hardly
/// contributes to it where the points are close together, and uncorrelated noise of deviation s gives
/// s * sqrt(sum w^2), w_i = 1 / prod_{j != i} (t_i - t_j). At equal distances this is the entry of the difference table
/// of More & Wild, "Estimating computational noise" (SIAM J. Sci. Comput. 33, 2011), eq. 2.4.
/// An upper estimate where the points are far apart. One sample: its spread is about its size.
/// @param t different places, at least 3  @param values as many
double noise_on_line(const Eigen::VectorXd& t, const Eigen::VectorXd& values);

/// Least change of a value that says anything: ten roundings of its size, or `measured` noise where that is more.
double resolution(double value, double measured);

/// Step of a forward difference that has the least error: 2 sqrt(noise / |curvature|), by More & Wild, "Estimating
/// derivatives of noisy simulations" (ACM TOMS 38, 2012), up to their factor 8^(1/4). @pre noise, curvature > 0
double best_difference_step(double noise, double curvature);

/// The noise of one function, from the values along lines that a search meets.
class ValueNoise {
public:
    void begin(double value_here);  ///< a new line begins at t = 0
    /// A value at t > 0 on it, of a point this far from the begin; farther points than 0.01, in variables whose
    /// reasonable steps are about 1, say more of the function than of its noise and are left out.
    void add(double t, double value);
    /// Root mean square of the last three samples of which differences of two orders agree, as those of noise do and
    /// those of a smooth function do not; 0: nothing is known.
    double level() const;

private:
    std::vector<double> t_, values_, samples_;
};

}  // namespace strake
