#pragma once
#include "optimize/run/stored_design.hpp"

/// A shape between two designs of one surface that is an equilibrium of the shell, too.
namespace strake {

/// One of the two: the problem of its run, and the design.
struct DesignOfRun {
    Problem problem;
    std::shared_ptr<const StoredDesign> design;
};

struct MixedDesign {
    Points vertices;     ///< n x 3
    Equilibrium end;     ///< of the solve
    std::string defect;  ///< why the surface cannot be handed on (`ValidityGuard`); empty: it can
    std::string beyond;  ///< in words, how far it is beyond the motion limit of a's problem; empty: it is within
};

/// The equilibrium under what the two designs ask of the shell, mixed: forces and motions linearly, prism heights by
/// their logarithms: (1 - weight) a + weight b. At 0 and 1 it is the designs themselves to the solver's tolerance;
/// beyond them the demands are extrapolated. The motion limit does not bound it.
/// @throws InvalidInput where there is no such shape between them: another surface, other pinned triangles, springs,
/// symmetry (what differs); a weight that is not finite.
MixedDesign mixed_design(const DesignOfRun& a, const DesignOfRun& b, double weight);

}  // namespace strake
