#pragma once
#include "optimize/shell_setup.hpp"

#include <memory>

/// The design variables of one level: x in scaled units <-> loads, strains and prism heights (DESIGN section 6).
/// A variable's unit is the change whose linear response at rest moves the surface by `max_displacement` at x = 1,
/// so that bounds and results depend neither on the unit of length nor on the mesh. A prism height moves nothing at
/// rest: its unit is ln 2.
namespace strake {

struct Variable {
    std::string name;  ///< patch and component: `wing.upper.load_x`
    VariableKind kind = VariableKind::load;
    int patch = 0;      ///< id in its level
    int component = 0;  ///< load: x, y, z; strain: rotation x, y, z, translation x, y, z; else 0
    double unit = 1;    ///< physical value at x = 1: 1/length, radians, length, or log of a factor
};

/// What x asks of the shell.
struct ShellDemand {
    Loads loads;
    std::vector<RigidMotion> motions;  ///< given strains first
    Eigen::VectorXd prism_height;      ///< per vertex
};

/// Facts about the start surface that every level shares.
struct RestFacts {
    TriMesh surface;
    Adjacency adjacent;
    Eigen::VectorXd area;  ///< m
    Points normal;         ///< m x 3, unit
    Eigen::VectorXd vertex_area;
    double diagonal = 0;
    ShellSetup setup;
    Points given_traction;  ///< m x 3, or empty
    std::shared_ptr<const PatchHierarchy> tree;
    Parameters parameters;
};
std::shared_ptr<const RestFacts> rest_facts(const Problem& problem);

struct DesignSpace {
    std::shared_ptr<const RestFacts> rest;
    int level = 0;
    std::vector<Variable> variables;
    /// size() x size(), positive definite: x.metric.x is the size of a small change x. The sum of the squared root mean
    /// square displacement (twice, over max_displacement) and of the elastic energy (over that of a soft load): neither
    /// soft collective motions nor stiff in-plane loads, which run into buckling, look harmless in it.
    Eigen::MatrixXd metric;
    Eigen::VectorXd lower, upper;        ///< per variable, scaled; [-1, 1] unless an inherited value lies outside
    std::vector<std::string> notes;      ///< variables left out, and why
    std::vector<int> pin;                ///< ShellOptions::pin of this level: fixed, given strains, then the cores
    std::vector<std::vector<int>> core;  ///< pinned triangles of each patch with strain variables; empty elsewhere
    std::vector<int> motion;  ///< per patch: number of its motion in `ShellDemand::motions`, -1 without a core
    std::vector<RigidMotion> carried_motion;  ///< per patch: about the core's area-weighted centroid, with what was
                                              ///< inherited and has no variable here
    Points carried_traction;                  ///< m x 3: inherited where this level has no variable for it; empty: none
    Eigen::VectorXd carried_log_height;       ///< m: the same of the logarithm of the height's factor; empty: none

    int size() const { return static_cast<int>(variables.size()); }
    const PatchLevel& patches() const { return rest->tree->levels[level]; }
    bool changes_height() const;  ///< some variable is a stiffness, or one was inherited
};

/// The space of `level` with x = 0 the undeformed start (under given loads and strains).
/// @throws InvalidInput: no such level; strain cores that leave no free prism. UnheldPart from the rest solve.
/// Cost: one factorization at rest and one back-substitution per variable.
DesignSpace design_space(std::shared_ptr<const RestFacts> rest, int level);

struct InheritedSpace {
    DesignSpace space;
    Eigen::VectorXd x;
};
/// The space of the next level, and its x that demands the same of the shell as `x` does of `parent`: equal traction,
/// equal motion and equal height of every triangle. Bounds are widened where an inherited value lies outside.
InheritedSpace refine(const DesignSpace& parent, const Eigen::VectorXd& x);

/// Tractions, motions and heights of x. Forces are summed over triangles in their order, whatever the patches.
ShellDemand demand(const DesignSpace& space, const Eigen::VectorXd& x);

/// dJ/dx (size()) from dJ/d(force, motion, height) at x.
Eigen::VectorXd design_gradient(const DesignSpace& space, const Eigen::VectorXd& x,
                                const ShellSensitivities& sensitivities);

/// dv/dx at the shell's equilibrium, column j as n x 3 points: one back-substitution each, in blocks.
/// `consume(j, dv)` is called in the order of the variables. @throws InvalidInput for stiffness variables.
void design_response(const DesignSpace& space, PrimoShell& shell,
                     const std::function<void(int j, const Points& dv)>& consume);

/// Physical values with names, for programs and for the files of a level.
std::vector<std::pair<std::string, double>> physical_values(const DesignSpace& space, const Eigen::VectorXd& x);

}  // namespace strake
