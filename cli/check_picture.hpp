#pragma once
#include "casefile/build/build_problem.hpp"
#include "cli/check_axes.hpp"
#include "report/drawing.hpp"

/// The picture of a case that `strake check --picture` writes: the body, what is held, its axes as arrows, its regions
/// and its patches.
namespace strake::cli {

/// Arrows at nose, top and wing tip of a panel that shows the surface: where the air goes, up, and the right wing (the
/// left one of a left half). @param diagonal of the surface
void add_axes_arrows(Panel& panel, const AxesFacts& axes, double diagonal);

/// Per triangle of the surface the number of its patch on this level, also where the patches are those of a wrap.
std::vector<int> labels_on_surface(const Problem& problem, const PatchLevel& level);

/// SVG with three views: obliquely from ahead and above, from the left, from above; then one of each region that the
/// case names and of the patches of each level, from where most of it is seen. Views along coordinate directions have
/// coordinates at their borders. Without axes, x and z stand for downstream and up, and there are no arrows.
std::string check_picture(const Case& the_case, const BuiltProblem& built, const std::optional<AxesFacts>& axes);

}  // namespace strake::cli
