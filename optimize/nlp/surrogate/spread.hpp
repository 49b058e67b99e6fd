#pragma once
#include <Eigen/Core>

/// Points spread over the unit cube. The same call gives the same bits on every machine.
namespace strake {

/// Rows `first`, ..., `first + count` - 1 of a digital (Sobol') sequence, moved by half a cell of 2^-32: count x
/// dimensions, in (0, 1). Of any 2^k points that begin at a multiple of 2^k, each of the 2^k equal parts of every
/// coordinate contains one; the sequence can be continued. Initial numbers are chosen here, so that pairs of
/// coordinates are even, too. @throws InvalidInput: dimensions outside [1, 1000], negative numbers.
Eigen::MatrixXd sobol_points(int first, int count, int dimensions);

/// Latin hypercube: each of the `count` equal parts of every coordinate contains one point, at random in it.
Eigen::MatrixXd latin_hypercube(int count, int dimensions, unsigned seed);

}  // namespace strake
