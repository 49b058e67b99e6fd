#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/aero/stream.hpp"

namespace strake {

struct FrictionFlow {
    Stream stream;                   ///< lengths and the force are along its drag axis
    double reynolds_per_length = 1;  ///< of the free stream, 1/length, > 0
    double mach = 0, gamma = 1.4;    ///< mach >= 0: at 0 incompressible
    bool turbulent = true;
    std::optional<double> wall_temperature = {};  ///< over the free stream's, > 0; default: adiabatic wall
    double temperature = 216.65;                  ///< of the free stream, K, > 0
    double reference_area = 1;                    ///< > 0
};

/// Skin friction D / (q reference_area) of flat plates laid along the stream on the wetted area:
///   sum over triangles of area times the mean of cf(l) over it (seven points)
///   laminar cf = 0.664 (C/Re_l)^(1/2),   turbulent cf = 0.0592 Re_l^(-1/5) with Eckert's reference temperature
///   T*/T = (1 + Tw/T)/2 + 0.22 r (gamma - 1)/2 M^2,   r = Pr^(1/2) or Pr^(1/3), Pr = 0.72,
/// density and viscosity (Sutherland) at T*. The local length l of a vertex is its distance along the stream from the
/// leading line, which joins the foremost vertices of the start surface, one in each strip across (about 2 edges wide,
/// seen from above), and moves with them. Below 1e-4 of the length, l is smoothed: (l + sqrt(l^2 + l0^2)) / 2. On
/// integration the laminar plate has 1.328 Re^(-1/2), the turbulent one 0.074 Re^(-1/5); near the leading edge the
/// seven points have an error of order (edge / length)^(1/2) or ^(4/5). The whole surface counts, including a base.
/// With `symmetry`: half the drag of the whole body. Cost: one pass over the triangles. Kinks: only at triangles of
/// zero area. Field name.cf, at the vertices.
/// @throws InvalidInput: numbers outside their limits; a flow that crosses the plane of symmetry.
Quantity friction(const std::string& name, const TriMesh& start, const FrictionFlow& flow,
                  const std::optional<SymmetryPlane>& symmetry = {});

/// cf = scale * reynolds^-exponent at the local Reynolds number; the scale includes compressibility.
struct PlateLaw {
    double scale, exponent;
};
PlateLaw plate_law(const FrictionFlow& flow);

}  // namespace strake
