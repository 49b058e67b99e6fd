#pragma once
#include "optimize/space/design_space.hpp"

/// Between the shell and the surface of a design. A wrap carries the surface along. Displacement fields move the
/// surface beside the shell; attached parts follow their hosts where these are in the end; and a kind of shape
/// (`Parameters::invariance`) lets through what of forces and motions keeps it.
/// `surface` is the surface of the design without the motion by the planform (n x 3), about which attached parts turn
/// and at which sections of wings are kept; null: the one at rest.
namespace strake {

/// The displacement of the surface by that of the shell's vertices, B u; without a wrap they are the same.
Points carried(const RestFacts& rest, const Points& of_shell);
/// Its transpose: what forces on the surface are on the shell.
Points pulled_to_shell(const RestFacts& rest, const Points& force);

/// What of a displacement of the surface (n x 3) a design has: P u, or K(u).
Points kept_motion(const RestFacts& rest, const Points& motion);
/// What of a small motion (n x 3) it has at that surface: P u, or the derivative of K times it.
Points kept_rates(const RestFacts& rest, const Points& motion, const Points* surface);
/// What of vertex forces acts: P^T f, or the transpose of K's derivative at rest times it: forces on a section are then
/// in balance with forces on its edges, and bend and twist no wing.
Points kept_forces(const RestFacts& rest, const Points& force);

/// dv of the surface by a motion of its points beside attached parts, which follow.
Points surface_rates(const RestFacts& rest, const Points& motion, const Points* surface);
/// The transpose: what forces on, or sensitivities of, the surface are to its points beside attached parts.
Points surface_pull(const RestFacts& rest, const Points& force, const Points* surface);

/// `PrimoShell::response` and `adjoint` of the surface instead of the shell. @param forces on the shell, as
/// `kept_forces` has them.
/// `shell` is null where the problem has none: forces then move nothing, and of the sensitivities `vertex` is left.
std::vector<Points> surface_response(const RestFacts& rest, PrimoShell* shell, const std::vector<Points>& forces,
                                     double tolerance, const Points* surface);
std::vector<ShellSensitivities> surface_adjoint(const RestFacts& rest, PrimoShell* shell,
                                                const std::vector<Points>& dJ_dv, const AdjointOptions& options,
                                                const Points* surface);

/// Forces on single vertices of the surface are forces on fields and shell as they are: nothing follows others, keeps a
/// kind of shape or moves with a planform, and the shell is elsewhere.
bool acts_as_given(const RestFacts& rest);
/// `surface_adjoint` of functionals of one vertex each (dJ/dv a row of `dJ_dv`), with the same bits; `vertex` of the
/// sensitivities is left empty: of millions of vertices one each would take gigabytes. @pre acts_as_given
std::vector<ShellSensitivities> adjoint_of_vertices(const RestFacts& rest, PrimoShell* shell,
                                                    const std::vector<int>& vertices, const Points& dJ_dv,
                                                    const AdjointOptions& options);

}  // namespace strake
