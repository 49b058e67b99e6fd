#pragma once
#include "optimize/space/design_space.hpp"

/// What can be known of a level's variables before anything is evaluated: from the shell's linear response at rest.
namespace strake {

struct SpaceFacts {
    int level = 0, patches = 0;
    std::vector<std::string> names;      ///< of the variables that are left
    std::vector<std::string> dependent;  ///< that move nothing or do what others do
    std::vector<std::string> notes;
    /// Largest over smallest eigenvalue of the response metric of the shape variables: how differently long equal steps
    /// of different directions move the surface. NaN without any.
    double condition = std::numeric_limits<double>::quiet_NaN();
    std::vector<char> moves;      ///< per vertex: some variable moves it by more than 1e-6 of its largest displacement
    bool changes_height = false;  ///< stiffness variables move nothing at rest: `moves` knows nothing of them
    double rest_seconds = 0;      ///< of one assembly, ordering and factorization, on a machine that does nothing else
};

/// @param mode called with every shape variable and its displacement (n x 3) at x = 1; may be empty.
/// Cost: two factorizations and two back-substitutions a variable. @throws as `design_space`.
SpaceFacts space_facts(const DesignSpace& space, const std::function<void(const Variable&, const Points&)>& mode = {});

}  // namespace strake
