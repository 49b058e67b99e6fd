#pragma once
#include "core/fields/displacement_fields.hpp"
#include "optimize/space/design_space.hpp"

/// What can the design variables make? Known before anything is evaluated, from the shell's linear response at rest.
namespace strake {

/// A motion, and how much of it the variables of each level can make.
struct MotionShare {
    std::string name;              ///< of `typical_motions`, or "soft mode 1"
    std::vector<double> by_level;  ///< share of the squared displacement (by area) that a combination makes, in [0, 1]
    std::string remedy;      ///< lines of the case that would add what is missing; empty: nothing is, or none known
    double with_remedy = 0;  ///< the share that the finest level makes with them
};

struct Capability {
    std::vector<int> levels, variables;  ///< number of each level that was asked, and of its variables
    std::vector<MotionShare> motions;
    int levels_not_asked = 0;  ///< finer ones, of more than `max_variables`
};

struct CapabilityOptions {
    int soft_modes = 3;       ///< motions of the shell that ask for least energy, >= 0; none where it is at rest alone
    int max_variables = 300;  ///< of a level, beyond which it is left out: each variable is a back-substitution
    double enough = 0.95;     ///< share from which on nothing is missing
    std::optional<Eigen::Vector3d> axis;  ///< of the sections
};

/// Cost: one factorization and one back-substitution per variable.
/// @throws as `design_space`.
Capability capability(const std::shared_ptr<const RestFacts>& rest, const FieldConditions& conditions,
                      const CapabilityOptions& options = {});

/// Share of the squared displacement (by area) that a combination of the columns makes. @param columns, motion as
/// `sampled_motion` has them.
double share_made(const Eigen::MatrixXd& columns, const Eigen::VectorXd& motion);

}  // namespace strake
