#pragma once
#include "core/primo/shell.hpp"

#include <string>
#include <vector>

/// The result of one evaluation of a design.
namespace strake {

enum class EvaluationStatus {
    ok,
    not_converged,   ///< the shell found no equilibrium
    unstable,        ///< it found one that is no stable minimum
    invalid,         ///< inverted, collapsed or folded: the surface is not handed on
    quantity_failed  ///< a quantity gave no value
};
std::string to_string(EvaluationStatus status);

struct ShapeEvaluation {
    EvaluationStatus status = EvaluationStatus::not_converged;
    std::string reason;                  ///< why it is not ok
    bool may_go_on = true;               ///< a quantity failed, but says that this is no reason to end the run
    Points vertices;                     ///< n x 3; empty unless a valid surface was reached
    std::vector<double> values;          ///< in the order of `ShapeEvaluator::names()`; empty unless ok
    std::vector<Points> dJ_dv;           ///< of the differentiated values, in their order; empty without gradients
    bool has_gradients_to_come = false;  ///< dJ_dv is still empty: `differentiate` asks for it
    std::vector<Eigen::VectorXd> dJ_dp;  ///< the same by the parameters; NaN: not given (with finite_differences)
    Eigen::MatrixXd gradients;  ///< differentiated values x variables, once `differentiate` was called; NaN as above
    std::vector<ShellSensitivities> sensitivities;  ///< of the differentiated values, from the same call
    double max_displacement = 0;                    ///< from the start surface, length
    bool is_taken_over = false;  ///< the values are those of the same shape on the level before; nothing was called
    std::vector<std::string> remarks;  ///< of the quantities, for the log
    std::string surface;               ///< with a journal: hash of the surface; empty: none
};

}  // namespace strake
