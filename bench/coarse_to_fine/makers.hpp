#pragma once
#include "bench/coarse_to_fine/parts.hpp"

/// The problems one by one; `draw` gives what depends on the seed.
namespace strake::evidence {

EvidenceProblem wing_recovery(int triangles, Draw& draw);
EvidenceProblem lifting_body_recovery(int triangles, Draw& draw);
EvidenceProblem fuselage_recovery(int triangles, Draw& draw);
EvidenceProblem bent_tube(int triangles, Draw& draw);
EvidenceProblem blob(int triangles, Draw& draw);
EvidenceProblem bunny_like(int triangles, Draw& draw);
EvidenceProblem lifting_body_volume(int triangles, Draw& draw);
EvidenceProblem wing_under_limits(int triangles, Draw& draw);
EvidenceProblem local_bump(int triangles, Draw& draw);
EvidenceProblem global_twist(int triangles, Draw& draw);
EvidenceProblem noisy(int triangles, Draw& draw);
EvidenceProblem many_minima(int triangles, Draw& draw);

EvidenceProblem wave_drag_beside_fuselage(int triangles, Draw& draw);
EvidenceProblem newtonian_lift_over_drag(int triangles, Draw& draw);
EvidenceProblem min_bending(int triangles, Draw& draw);
EvidenceProblem wing_within_thickness(int triangles, Draw& draw);
EvidenceProblem min_frontal_area(int triangles, Draw& draw);
EvidenceProblem wanted_section_areas(int triangles, Draw& draw);

}  // namespace strake::evidence
