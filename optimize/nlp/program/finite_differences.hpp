#pragma once
#include "optimize/nlp/program/nonlinear_program.hpp"

/// Gradients by differences of values.
namespace strake {

/// The program with gradients by differences: one evaluation (central: two) for each variable of which an entry is
/// wanted. They count as evaluations, stay within the bounds (a forward step that does not fit goes backward) and are
/// never the result.
/// @throws InvalidInput: step not > 0, number of rows.
NonlinearProgram with_differences(NonlinearProgram program, const Differences& how);

/// Writes the gradients that `program.differences` names into the evaluation at x. Points that fail are replaced, after
/// all others, by those on the other side; false: one of these failed too, the evaluation is unchanged. Variables with
/// equal bounds get zero.
/// @param evaluate the program's, counted. @param expect receives the points before they are evaluated; may be empty.
bool differentiate_by_differences(const NonlinearProgram& program, const Eigen::VectorXd& x, Evaluation& evaluation,
                                  const std::function<Evaluation(const Eigen::VectorXd& x)>& evaluate,
                                  const std::function<void(const std::vector<Eigen::VectorXd>&)>& expect = {});

}  // namespace strake
