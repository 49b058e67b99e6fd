#pragma once
#include "objectives/quantity/quantity.hpp"

#include <cstdint>

/// What the problems of the suite measure beyond the built-in quantities. All sensitivities are exact.
namespace strake::evidence {

/// Numbers in [0, 1) from a seed, the same on every machine.
class Draw {
public:
    explicit Draw(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ull + 0x632BE59BD9B4E019ull) {}
    double between(double low, double high);
    double sign() { return between(0, 1) < 0.5 ? -1 : 1; }
    Eigen::Vector3d direction();  ///< uniform on the unit sphere

private:
    std::uint64_t state_;
};

/// (1 + J / J(start)) (1 + 1e-4 n), n in [-1, 1] a hash of the vertices' bits: what an iterative solver leaves. The
/// sensitivities are those without the noise, as an adjoint solver's are. One value, called `name`.
Quantity with_noise(const std::string& name, const Quantity& smooth, const TriMesh& start, std::uint64_t seed);

/// J / J(start) plus ripples: share / m sum_j (1 - cos(2 pi c_j / wave_j)), c_j the mean over parcel j of the
/// residual along z to `wanted`, wave_j = |c_j(start)| / 2.5 (not below a tenth of the largest): every mean passes
/// several minima on its way, and the only one with the value 0 is the target.
Quantity with_ripples(const std::string& name, const Quantity& smooth, const TriMesh& start, const Points& wanted,
                      const std::vector<std::vector<int>>& parcels, double share);

/// Two values, `thinnest` and `thickest`: soft minimum and maximum (exponent 60) over pairs of vertices of their
/// distance along z over that at the start.
Quantity pair_thickness(const TriMesh& start, const std::vector<std::pair<int, int>>& pairs);

/// Mean square change of the discrete mean curvature normal, times the squared diagonal: sum a_k |(L u)_k|^2 / sum a_k,
/// u = v - start, L u_k = 4 / l_k^2 (mean of u over the neighbours - u_k), l_k^2 the mean square edge length at k.
Quantity curvature_change(const TriMesh& start);

}  // namespace strake::evidence
