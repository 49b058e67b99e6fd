#include "optimize/least_squares/least_squares_watch.hpp"

/// Where STRAKE_GPL is off: our own search in the place of Ceres, whose library in Debian is linked with GPL parts.
namespace strake {

LeastSquaresEnd search_least_squares(LeastSquaresWatch& watch, double& radius) {
    return levenberg_marquardt(watch, radius);
}

}  // namespace strake
