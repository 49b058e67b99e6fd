#pragma once
#include "casefile/schema/schema.hpp"

/// The rows of the table, topic by topic. Between the schema's files; not for others.
namespace strake {

std::vector<Key> surface_keys();            ///< case, surface, regions, fixed, symmetry, axes
std::vector<Key> planform_keys();           ///< planform
std::vector<Key> wing_region_keys();        ///< regions of a wing
std::vector<Key> repair_and_remesh_keys();  ///< repair, remesh
std::vector<Key> shell_keys();              ///< shell, loads, strains, attach
std::vector<Key> parameter_keys();          ///< parameters
std::vector<Key> user_variable_keys();      ///< parameters.given
std::vector<Key> program_parameter_keys();  ///< variables
std::vector<Key> quantity_keys();           ///< quantities: built in
std::vector<Key> program_keys();            ///< quantities.* of programs
std::vector<Key> geometry_keys();           ///< quantities.* of the geometric types
std::vector<Key> aero_keys();               ///< quantities.* of the aerodynamic types
std::vector<Key> goal_keys();               ///< objective, fit, constraints
std::vector<Key> run_keys();                ///< optimize, output

/// The lists one after the other.
std::vector<Key> in_order(const std::vector<std::vector<Key>>& lists);

inline constexpr double no_limit = std::numeric_limits<double>::infinity();
inline constexpr Limits positive{0, no_limit, true, false};
inline constexpr Limits not_negative{0, no_limit, false, false};
inline constexpr Limits at_least_one{1, no_limit, false, false};

}  // namespace strake
