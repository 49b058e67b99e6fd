#pragma once
#include "optimize/space/response_metric.hpp"

/// Directions of a design space that move nothing: loads that cancel, and patches that move almost nothing. Internal.
namespace strake {

/// The linear responses of variables that depend on others: each response is that of `kept` times its column of
/// `share`, but for less than `null_share` of it (root mean square over the surface).
struct Dependence {
    std::vector<int> kept, dependent;
    Eigen::MatrixXd share;  ///< kept x dependent
    /// Per kept one: what of its response those before it cannot do, as a share of it; 1 for columns of zeros.
    std::vector<double> own;
};

/// Below this share of its own response, a variable adds nothing to the others.
constexpr double null_share = 1e-6;

/// Below this a variable is kept and named: it takes large values against the others to do what only it can do. Three
/// loads on each of 384 patches of a wing leave 8e-5.
constexpr double weak_share = 1e-5;

/// By elimination in the Gram matrix of the responses, in their order: of variables that depend on each other the later
/// ones are called dependent. Columns of zeros (stiffness has no response) are kept.
Dependence dependence(const Eigen::MatrixXd& responses);

/// The dependent variables of the space, in one line: "2 of 14 directions move the surface by less than ...".
std::string null_words(const DesignSpace& space);
/// The same of those that are kept although they are weak, with the least share. @pre space.weak is not empty.
std::string weak_words(const DesignSpace& space, double least);

}  // namespace strake
