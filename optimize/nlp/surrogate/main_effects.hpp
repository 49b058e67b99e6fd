#pragma once
#include "optimize/nlp/surrogate/gaussian_process.hpp"

/// Which coordinate a function depends on, by a model of it (Sobol' 1993; Oakley and O'Hagan 2004).
namespace strake {

struct MainEffects {
    Eigen::VectorXd share;  ///< per coordinate: var(E[f | x_j]) / var(f), in [0, 1]; zero for a constant
    Eigen::VectorXd error;  ///< standard error of the share, by a jackknife over ten groups of points
    Eigen::VectorXd total;  ///< per coordinate: 1 - var(E[f | all others]) / var(f): with all interactions
    double deviation = 0;   ///< root of var(f)
    /// E[f | x_j] at `places` equidistant places from lower to upper, places x coordinates.
    Eigen::MatrixXd curve;
};

/// Coordinates are independent and uniform between the bounds; integrals by Gauss and Legendre for each coordinate,
/// exact to round-off for length scales above a twentieth of a range.
/// @pre lower < upper, sizes as the model's. Cost: d n^2 for each group.
MainEffects main_effects(const GaussianProcess& model, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                         int places = 21);

}  // namespace strake
