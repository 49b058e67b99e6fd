#pragma once
#include "optimize/problem/problem.hpp"

/// Values along one or more design variables, without an optimizer: what the objective looks like, where shapes cease
/// to exist, how noisy a program is.
///
///     Sweep s = sweep(problem, {{{"wing.load_z", -1, 1, 11}}, 1});
namespace strake {

struct SweepAxis {
    std::string variable;
    /// Of the scaled variable: 1 moves the surface by about `max_displacement`. Of a parameter its value itself.
    double from = -1, to = 1;
    int steps = 11;  ///< points, both ends included; one point: `from`
};

struct SweepOptions {
    std::vector<SweepAxis> axes;  ///< all other variables are 0: no load, parameters at their start
    int level = 1;                ///< of the tree
};

struct SweepPoint {
    std::vector<double> x;         ///< per axis, scaled
    std::vector<double> physical;  ///< per axis: 1/length, radians, length, log of a factor, value of a parameter
    std::string status;            ///< "ok", or why there is no value, in one word
    std::string reason;            ///< the same in words; empty when ok
    double objective = std::numeric_limits<double>::quiet_NaN();  ///< of a fit the sum of rho; NaN: none
    std::vector<double> values;                                   ///< of all quantities; empty when not ok
};

struct Sweep {
    std::vector<std::string> names;  ///< of the values
    std::vector<SweepPoint> points;  ///< the last axis runs fastest
};

constexpr int max_sweep_points = 1000;

/// Each point is reached from the start shape on its own: it depends neither on the range nor on its
/// neighbours. A shape or a value that does not exist is a row with its status.
/// @param each is called after each point. Cost: one equilibrium and one evaluation of all quantities a point.
/// @throws InvalidInput: no axis, one twice, an unknown variable (with those that exist), a range that is not finite,
/// fewer than one or more than `max_sweep_points` points, a parameter out of its bounds, no such level; UnheldPart,
/// OutputError.
Sweep sweep(const Problem& problem, const SweepOptions& options,
            const std::function<void(const SweepPoint&)>& each = {});

}  // namespace strake
