#pragma once
#include "optimize/space/design_space.hpp"

/// Between the shell and the surface of a design. A wrap carries the surface along. Displacement fields move the
/// surface beside the shell; attached parts follow their hosts where these are in the end; and a kind of shape
/// (`Parameters::invariance`) lets through what of forces and motions keeps it. `surface` is the surface of the design
/// (n x 3), about which attached parts turn; null: the one at rest.
namespace strake {

/// The displacement of the surface by that of the shell's vertices, B u; without a wrap they are the same.
Points carried(const RestFacts& rest, const Points& of_shell);
/// Its transpose: what forces on the surface are on the shell.
Points pulled_to_shell(const RestFacts& rest, const Points& force);

/// What of a displacement of the surface (n x 3) a design may have: P u.
Points kept_motion(const RestFacts& rest, const Points& motion);
/// What of vertex forces acts: P^T f.
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

}  // namespace strake
