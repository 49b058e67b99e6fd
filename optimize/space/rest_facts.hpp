#pragma once
#include "core/mesh/adjacency.hpp"
#include "optimize/problem/shell_setup.hpp"

#include <memory>

namespace strake {

class ResponseCache;

/// Facts about the start surface that every level shares.
struct RestFacts {
    TriMesh surface;
    Adjacency adjacent;
    Eigen::VectorXd area;  ///< m
    Points normal;         ///< m x 3, unit
    Eigen::VectorXd vertex_area;
    double diagonal = 0;
    bool has_shell = true;  ///< `Problem::has_shell`
    ShellSetup setup;
    Points given_traction;  ///< m x 3, or empty
    std::shared_ptr<const PatchHierarchy> tree;
    Parameters parameters;
    std::vector<ProgramParameter> program_parameters;
    std::optional<SymmetryPlane> mirror;   ///< plane of symmetry of the surface, where `parameters.mirror` asks for it
    std::shared_ptr<ResponseCache> cache;  ///< responses at rest of variables met so far
    std::vector<std::string> notes;
};
/// @throws InvalidInput: limits of `Parameters`, no plane of symmetry where one is asked for, and as `shell_setup`.
std::shared_ptr<const RestFacts> rest_facts(const Problem& problem);

}  // namespace strake
