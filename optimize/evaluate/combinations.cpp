#include "optimize/evaluate/combinations.hpp"

#include "core/error.hpp"

#include <algorithm>

namespace strake {

Combinations::Combinations(const std::vector<Quantity>& quantities, const std::vector<ProgramParameter>& parameters) {
    std::vector<std::string> names;
    for (const Quantity& quantity : quantities) {
        std::optional<Made> made;
        if (quantity.combination) {
            made.emplace().of_parts = quantity.combination->value;
            for (const std::string& part : quantity.combination->of) {
                const auto value = std::find(names.begin(), names.end(), part);
                const auto variable = std::find_if(parameters.begin(), parameters.end(),
                                                   [&](const ProgramParameter& v) { return v.name == part; });
                if (value == names.end() && variable == parameters.end())
                    throw InvalidInput(text(quantity.names.at(0), ": '", part, "' is no value of a quantity above it"));
                made->parts.push_back(value != names.end() ? static_cast<int>(value - names.begin())
                                                           : -1 - static_cast<int>(variable - parameters.begin()));
            }
        }
        for (std::size_t i = 0; i < quantity.names.size(); ++i) made_.push_back(made);
        names.insert(names.end(), quantity.names.begin(), quantity.names.end());
    }
}

std::vector<int> Combinations::with_parts(const std::vector<int>& values) const {
    std::vector<char> wanted(made_.size(), 0);
    for (const int i : values) wanted[static_cast<std::size_t>(i)] = 1;
    std::vector<int> all;
    // Parts stand before what is made of them.
    for (std::size_t i = made_.size(); i-- > 0;) {
        if (!wanted[i]) continue;
        all.insert(all.begin(), static_cast<int>(i));
        if (made_[i])
            for (const int part : made_[i]->parts)
                if (part >= 0) wanted[static_cast<std::size_t>(part)] = 1;
    }
    return all;
}

Eigen::VectorXd Combinations::parts_of(const Made& made, const std::vector<double>& values,
                                       const std::vector<double>& parameters) const {
    Eigen::VectorXd at(static_cast<Eigen::Index>(made.parts.size()));
    for (Eigen::Index k = 0; k < at.size(); ++k) {
        const int part = made.parts[static_cast<std::size_t>(k)];
        at[k] =
            part >= 0 ? values.at(static_cast<std::size_t>(part)) : parameters.at(static_cast<std::size_t>(-1 - part));
    }
    return at;
}

double Combinations::value(int i, const std::vector<double>& values, const std::vector<double>& parameters) const {
    const Made& made = *made_.at(static_cast<std::size_t>(i));
    return made.of_parts(parts_of(made, values, parameters), nullptr);
}

void Combinations::differentiate(const std::vector<int>& wanted, const std::vector<double>& values,
                                 const std::vector<double>& parameters, std::vector<Points>& dJ_dv,
                                 std::vector<Eigen::VectorXd>& dJ_dp) const {
    for (const int i : wanted) {
        const auto& made = made_[static_cast<std::size_t>(i)];
        if (!made) continue;
        Eigen::VectorXd by_part;
        made->of_parts(parts_of(*made, values, parameters), &by_part);
        Points by_vertex;
        Eigen::VectorXd by_parameter;
        const auto count = static_cast<Eigen::Index>(parameters.size());
        bool complete = true;
        for (std::size_t k = 0; k < made->parts.size(); ++k) {
            const int part = made->parts[k];
            const double weight = by_part[static_cast<Eigen::Index>(k)];
            Eigen::VectorXd share;
            if (part < 0)
                share = weight * Eigen::VectorXd::Unit(count, -1 - part);
            else {
                const Points& of_part = dJ_dv[static_cast<std::size_t>(part)];
                complete = complete && of_part.rows() > 0;
                if (by_vertex.rows() == 0) by_vertex = Points::Zero(of_part.rows(), 3);
                if (complete) by_vertex += weight * of_part;
                share = weight * dJ_dp[static_cast<std::size_t>(part)];
            }
            if (share.size() == 0) continue;
            if (by_parameter.size() == 0) by_parameter = Eigen::VectorXd::Zero(share.size());
            by_parameter += share;
        }
        dJ_dv[static_cast<std::size_t>(i)] = complete ? by_vertex : Points();
        dJ_dp[static_cast<std::size_t>(i)] = by_parameter;
    }
}

}  // namespace strake
