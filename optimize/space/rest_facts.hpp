#pragma once
#include "core/mesh/adjacency.hpp"
#include "optimize/problem/shell_setup.hpp"

#include <memory>

namespace strake {

class ResponseCache;
class WrapMap;

/// Facts about the start surface that every level shares.
struct RestFacts {
    TriMesh surface;
    Adjacency adjacent;  ///< of the surface; with a wrap, whose shell is elsewhere, none: it is as large as a surface
    std::shared_ptr<const WrapMap> wrap;  ///< `Problem::wrap`
    Eigen::VectorXd area;                 ///< m, of the elastic surface
    Points normal;                        ///< m x 3, unit, of the elastic surface
    Eigen::VectorXd vertex_area;          ///< of the surface
    Eigen::VectorXd wrap_vertex_area;     ///< of the wrap; empty: there is none
    double diagonal = 0;                  ///< of the surface
    double energy_share = 1;              ///< of elastic energies that the metric counts
    /// Beside fields, patches get variables one by one as they promise, the others rest: by gradients alone.
    bool takes_single_patches = false;
    bool has_shell = true;  ///< `Problem::has_shell`
    ShellSetup setup;
    Points given_traction;  ///< m x 3, or empty
    std::shared_ptr<const PatchHierarchy> tree;
    Parameters parameters;
    std::vector<ProgramParameter> program_parameters;
    std::optional<SymmetryPlane> mirror;   ///< plane of symmetry of the surface, where `parameters.mirror` asks for it
    std::shared_ptr<ResponseCache> cache;  ///< responses at rest of variables met so far
    std::vector<std::string> notes;

    /// What is elastic: the wrap, or where there is none the surface.
    const TriMesh& elastic() const;
    const Adjacency& elastic_adjacent() const;
    const Eigen::VectorXd& elastic_vertex_area() const { return wrap ? wrap_vertex_area : vertex_area; }
};
/// @param energy_share, takes_single_patches see there; > 0
/// @throws InvalidInput: limits of `Parameters`, no plane of symmetry where one is asked for, and as `shell_setup`.
std::shared_ptr<const RestFacts> rest_facts(const Problem& problem, double energy_share = 1,
                                            bool takes_single_patches = false);

}  // namespace strake
