#pragma once
#include "bench/coarse_to_fine/comparators.hpp"
#include "core/planform/wing.hpp"

/// What a wing designer sets up by hand where there are no variables of wings.
namespace strake::evidence {

/// A box of B-splines that is fitted to a wing: its planes along the span follow the sections, its points lie at
/// fractions of the chord between both edges, its height is that of the thickest place of each section.
struct WingBox {
    std::array<int, 3> points{6, 5, 2};  ///< along chord, span and height
    bool moves_downstream = false;       ///< points move along the stream, too, which changes chords and sweep
    bool root_held = false;              ///< those of the first plane along the span do not move
    double reach = 0.1;                  ///< of the mean chord: how far a point moves
    double twist = 0.0872664625997165;   ///< radians: range of the twist of the planes along the span; 0: none
};

/// Points move up (and downstream), then the planes of sections turn about their quarter chords, exactly: v = a +
/// R(theta) (v0 + W x - a), theta by the B-splines along the span. The root does not turn. Both sides of a whole wing
/// do the same; what is not of the wing stays. Scaled as `bezier_box` by the response at x = 0.
ComparedMotion wing_box(const TriMesh& surface, const Wing& wing, const WingBox& box);

}  // namespace strake::evidence
