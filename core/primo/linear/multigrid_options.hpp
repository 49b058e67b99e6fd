#pragma once

namespace strake {

struct MultigridOptions {
    double strength = 0.25;          ///< threshold of strong connections on the finest level
    int first_radius = 2;            ///< radius of the finest clusters, in connections; 1 on coarser levels
    int prolongation_steps = 1;      ///< damped Jacobi steps that smooth the finest prolongation
    int smoothing_steps = 3;         ///< degree of the finest Chebyshev polynomial, before and after each correction
    double smoothed_share = 0.1;     ///< the polynomial damps the spectrum from here to 1
    double coarse_strength = 0.125;  ///< the same on the levels below
    int coarse_prolongation_steps = 1;
    int coarse_smoothing_steps = 3;
    double coarse_share = 0.1;
    int direct_size = 400;          ///< largest level that is factorized, in block rows
    double inner_tolerance = 0.25;  ///< residual after the first coarse cycle that makes a second unnecessary
};

/// How the two cycles on each coarser level are combined: `best` as conjugate gradients would, which depends on the
/// right-hand side; `linear` by addition, a symmetric linear map up to round-off, slightly weaker.
enum class Cycle { best, linear };

}  // namespace strake
