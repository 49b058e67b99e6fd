#include "optimize/evaluate/constraints.hpp"

#include "core/error.hpp"

namespace strake {

std::pair<int, int> count_constraints(const std::vector<Constraint>& constraints) {
    std::pair<int, int> count{0, 0};
    for (const Constraint& c : constraints) {
        if (!c.min && !c.max && !c.equals)
            throw InvalidInput(text("constraint on ", c.quantity, " has no limit; give min, max or equals"));
        if (c.equals && (c.min || c.max))
            throw InvalidInput(text("constraint on ", c.quantity, ": equals excludes min and max"));
        if (c.min && c.max && *c.min > *c.max)
            throw InvalidInput(text("constraint on ", c.quantity, ": min = ", *c.min, " is above max = ", *c.max));
        count.first += (c.min ? 1 : 0) + (c.max ? 1 : 0);
        count.second += c.equals ? 1 : 0;
    }
    return count;
}

ConstraintRows constraint_rows(const std::vector<Constraint>& constraints, const std::vector<int>& index,
                               const std::vector<int>& gradient, const std::vector<double>& start_values) {
    ConstraintRows result;
    std::vector<ConstraintRow> equalities;
    for (std::size_t i = 0; i < constraints.size(); ++i) {
        const Constraint& c = constraints[i];
        const double start = start_values[index[i]];
        if (c.relative && start == 0)
            throw InvalidInput(text("constraint on ", c.quantity,
                                    ": its limits are multiples of the value at the start, which is 0; give numbers, "
                                    "without `relative`"));
        // Shares of a negative value: the larger share is the smaller number.
        const double turn = c.relative && start < 0 ? -1 : 1;
        const auto row = [&](double sign, double limit) {
            if (c.relative) limit *= start;
            const double scale = limit != 0 ? std::abs(limit) : start != 0 ? std::abs(start) : 1;
            return ConstraintRow{index[i], gradient[i], sign, limit, scale};
        };
        if (c.min) result.rows.push_back(row(-turn, *c.min));
        if (c.max) result.rows.push_back(row(turn, *c.max));
        if (c.equals) equalities.push_back(row(1, *c.equals));
    }
    result.num_inequalities = static_cast<int>(result.rows.size());
    result.rows.insert(result.rows.end(), equalities.begin(), equalities.end());
    return result;
}

}  // namespace strake
