#pragma once
#include "optimize/problem/problem.hpp"

/// Constraints of a problem in the scaled form that the minimizer takes. Internal.
namespace strake {

/// One row: sign * (value - limit) / scale, <= 0 or = 0.
struct ConstraintRow {
    int value = 0;     ///< index among the evaluator's values
    int gradient = 0;  ///< row among the differentiated values
    double sign = 1, limit = 0, scale = 1;
    double of(double q) const { return sign * (q - limit) / scale; }
};

/// Inequalities first, then equalities. Relative limits are multiples of `start_values`: with min 0.9 and max 1.1 a
/// value that starts at -50 stays between -55 and -45. Scaled by the limit, or where that is zero by the value at the
/// start.
struct ConstraintRows {
    std::vector<ConstraintRow> rows;
    int num_inequalities = 0;
};

/// @param index value of each constraint, `gradient` its row. @throws InvalidInput: a relative limit of a
/// value that is zero at the start.
ConstraintRows constraint_rows(const std::vector<Constraint>& constraints, const std::vector<int>& index,
                               const std::vector<int>& gradient, const std::vector<double>& start_values);

/// How many inequalities and equalities the constraints make. @throws InvalidInput when min > max, or without a limit.
std::pair<int, int> count_constraints(const std::vector<Constraint>& constraints);

}  // namespace strake
