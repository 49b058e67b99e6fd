#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

/// Gradients of values that have none of their own.
namespace strake {

struct NonlinearProgram;
struct Sample;

struct Differences {
    double step = 1e-4;      ///< in the variables of the program, > 0: well above the noise of the values
    bool central = false;    ///< twice the evaluations, error h^2 instead of h
    bool objective = true;   ///< false: `differentiate` gives its gradient
    std::vector<char> rows;  ///< per constraint: 0, `differentiate` gives its gradient; empty: differences for all
    bool missing = false;    ///< also the single entries that `differentiate` has left NaN
};

/// The program with gradients by differences: one evaluation (two: central) for each variable with an entry that is
/// asked for. They count as evaluations, stay within the bounds (a forward step that does not fit goes backward) and
/// are never the result.
/// @throws InvalidInput: step not > 0, number of rows.
NonlinearProgram with_differences(NonlinearProgram program, const Differences& how);

/// Writes the gradients that `program.differences` names into the sample at x. Points that fail are replaced, after all
/// others, by the ones on the other side; false: one of these failed too, the sample is as it was. Variables with equal
/// bounds get zero.
/// @param evaluate as the program's, and counts. @param expect told the points before they are evaluated; may be empty.
bool differentiate_by_differences(const NonlinearProgram& program, const Eigen::VectorXd& x, Sample& sample,
                                  const std::function<Sample(const Eigen::VectorXd& x)>& evaluate,
                                  const std::function<void(const std::vector<Eigen::VectorXd>&)>& expect = {});

}  // namespace strake
