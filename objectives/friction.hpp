#pragma once
#include "core/mesh/symmetry_plane.hpp"
#include "objectives/stream.hpp"

namespace strake {

struct FrictionFlow {
    Stream stream;                   ///< the drag axis is where lengths are measured and the force is told
    double reynolds_per_length = 1;  ///< of the free stream, 1/length, > 0
    double mach = 0, gamma = 1.4;    ///< mach >= 0: at 0 incompressible
    bool turbulent = true;
    std::optional<double> wall_temperature = {};  ///< over that of the free stream, > 0; without it adiabatic
    double temperature = 216.65;                  ///< of the free stream, K, > 0
    double reference_area = 1;                    ///< > 0
};

/// Skin friction D / (q reference_area) of flat plates laid along the stream on the wetted area:
///   sum over triangles of area times the mean of cf(l) over it (seven points)
///   laminar cf = 0.664 (C/Re_l)^(1/2),   turbulent cf = 0.0592 Re_l^(-1/5) with Eckert's reference temperature
///   T*/T = (1 + Tw/T)/2 + 0.22 r (gamma - 1)/2 M^2,   r = Pr^(1/2) or Pr^(1/3), Pr = 0.72,
/// density and viscosity (Sutherland) at T*. The local length l of a vertex is its distance along the stream from the
/// line that joins the foremost vertices of the start surface in strips across (some 2 edges wide, seen from above); it
/// moves with these vertices. l is rounded off below 1e-4 of the length: (l + sqrt(l^2 + l0^2)) / 2. On integration the
/// laminar plate has 1.328 Re^(-1/2), the turbulent one 0.074 Re^(-1/5); near the leading edge the seven points leave
/// an error of order (edge / length)^(1/2) or ^(4/5). All of the surface counts, a base too. With `symmetry` half
/// of the whole body's. Cost: one pass over the triangles. Kinks: none but those of the area (triangles of area zero).
/// Its field is name.cf, at the vertices.
/// @throws InvalidInput: numbers outside of their limits, a plane of symmetry that the flow crosses.
Quantity friction(const std::string& name, const TriMesh& start, const FrictionFlow& flow,
                  const std::optional<SymmetryPlane>& symmetry = {});

/// cf at the local Reynolds number `reynolds` is scale * reynolds^-exponent; compressibility is in the scale.
struct PlateLaw {
    double scale, exponent;
};
PlateLaw plate_law(const FrictionFlow& flow);

}  // namespace strake
