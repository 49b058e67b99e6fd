#pragma once
#include "optimize/problem/problem.hpp"

/// Values that are made of other values of the same evaluation (`Quantity::combination`). Internal.
namespace strake {

class Combinations {
public:
    /// @throws InvalidInput: a part that is neither a value further up in the list nor a parameter.
    Combinations(const std::vector<Quantity>& quantities, const std::vector<ProgramParameter>& parameters);

    /// These values and all that they are made of, ascending. Places among the values of all quantities in their order.
    std::vector<int> with_parts(const std::vector<int>& values) const;

    /// Value i, which is a combination, from those before it. @param parameters physical values of the parameters.
    double value(int i, const std::vector<double>& values, const std::vector<double>& parameters) const;

    /// Fills the derivatives of the combinations among `wanted` (as `with_parts` gives them) from those of their parts:
    /// by the vertices; by the parameters (none where no part has any). Without sensitivities of a part: 0 rows.
    void differentiate(const std::vector<int>& wanted, const std::vector<double>& values,
                       const std::vector<double>& parameters, std::vector<Points>& dJ_dv,
                       std::vector<Eigen::VectorXd>& dJ_dp) const;

private:
    struct Made {
        std::function<double(const Eigen::VectorXd&, Eigen::VectorXd*)> of_parts;
        std::vector<int> parts;  ///< places; of parameters -1 - place
    };
    Eigen::VectorXd parts_of(const Made& made, const std::vector<double>& values,
                             const std::vector<double>& parameters) const;
    std::vector<std::optional<Made>> made_;  ///< per value
};

}  // namespace strake
