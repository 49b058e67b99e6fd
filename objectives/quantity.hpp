#pragma once
#include "core/mesh/mesh.hpp"

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// The one interface of everything that can be optimized or constrained: built-in measures and other
/// people's programs alike. A quantity gives one or more values and, when asked, their exact vertex sensitivities.
namespace strake {

/// Why there is no value. Failing is a result, never an exception and never a number.
struct Failure {
    std::string kind;     ///< one word: spawn, exit, signal, timeout, no_result, unreadable, missing_key, wrong_type,
                          ///< not_finite, wrong_count, undefined
    std::string message;  ///< where, what, expected; for a program with the last lines of its log
};

/// What is to be evaluated. `surface` is the deformed surface; the rest is for programs that want to know.
struct QuantityRequest {
    const TriMesh& surface;
    bool want_sensitivities = false;
    int evaluation = 0;  ///< number of this evaluation within the run, from 1
    int level = 0;
    std::vector<std::pair<std::string, double>> variables;  ///< names and physical values of the design variables
};

struct QuantityResult {
    std::vector<double> values;  ///< one per name; empty after a failure
    std::vector<Points> dJ_dv;   ///< n x 3 per value; empty when not asked for
    std::optional<Failure> failure;
};

/// Pointwise residuals of a fit: J = sum of squares of r.
struct PointResiduals {
    Points r;                            ///< n x 3, length (weights included)
    std::vector<Eigen::Matrix3d> dr_dv;  ///< n: derivative of row k with respect to vertex k
};

struct Quantity {
    std::vector<std::string> names;  ///< one per value: "volume", or "aero.drag", "aero.lift"
    std::function<QuantityResult(const QuantityRequest&)> evaluate;
    std::function<PointResiduals(const TriMesh&)> residuals;  ///< empty where the quantity has none
};

}  // namespace strake
