#pragma once
#include "core/mesh/mesh.hpp"

/// Wings whose sections are the NACA four-digit thickness form with a sharp trailing edge (Abbott & von Doenhoff,
/// "Theory of Wing Sections", 1959, section 6.4; last coefficient -0.1036 in place of -0.1015, which closes the
/// trailing edge; chord 1):
///     z(x) = 5 t (0.2969 sqrt(x) - 0.1260 x - 0.3516 x^2 + 0.2843 x^3 - 0.1036 x^4)
namespace strake::example {

/// Half thickness at x in [0, 1], exactly 0 at both ends; t is the thickness over the chord.
double naca_half_thickness(double thickness, double x);

/// Swept tapered wing in the proportions of the ONERA M6 (AGARD AR-138, B1): x downstream, y along the span, z up.
struct WingShape {
    double root_chord = 0.8059;
    double semi_span = 1.1963;  ///< of the trapezoid; the rounded tip lies outside of it
    double taper = 0.562;       ///< tip chord over root chord
    double sweep_deg = 30;      ///< of the leading edge
    double thickness = 0.098;   ///< over the chord, as that wing's section
};

/// Half model: open at the root, whose boundary vertices lie exactly on y = 0; else closed. Leading edge at the root is
/// the origin. The tip is half a body of revolution about the tip chord. Symmetric in z, bit for bit. Edge length near
/// uniform, half of it at the leading edge; normals point outward.
/// @param triangles wanted, 1 000 to 5 000 000; met within 5 %. @throws InvalidInput outside of it.
TriMesh wing(int triangles, const WingShape& shape = {});

/// Straight wing of chord 1 without taper, open at both ends (y = 0 and y = span), on a structured grid: cosine-spaced
/// panels along the chord, cells of equal width along the span.
/// @throws InvalidInput on fewer than two panels, no cells, or a thickness or span that is not > 0.
TriMesh naca_wing(double thickness, int panels_per_side, int span_cells, double span = 1);

}  // namespace strake::example
