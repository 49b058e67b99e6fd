#pragma once
#include "core/mesh/mesh.hpp"

#include <Eigen/SparseCore>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// The interface of everything that can be optimized or constrained: built-in measures and external programs. A
/// quantity returns one or more values and, on request, their exact vertex sensitivities.
namespace strake {

/// Why there is no value. A failure is a result, never an exception and never a number.
struct Failure {
    std::string kind;     ///< one word: spawn, exit, signal, timeout, no_result, unreadable, missing_key, wrong_type,
                          ///< not_finite, wrong_count, undefined, exception
    std::string message;  ///< where, what, expected; for a program also the last lines of its log
};

/// Thrown when the user stops the run: the evaluation has not failed, it was abandoned. Not a std::exception, because
/// no handler may take it for an error.
struct Interrupted {
    std::vector<std::string> pending = {};  ///< jobs still in the queue, for the log
};

/// A program call that somebody else makes (`strake step`).
struct AwaitedCall {
    std::string quantity;
    int evaluation = 0;
    std::string folder;                ///< with the surface
    std::string request;               ///< file in it
    std::vector<std::string> command;  ///< as it would be run in that folder
};
/// Thrown, like Interrupted, while these calls are pending.
struct Awaited {
    std::vector<AwaitedCall> calls;
};

/// An evaluation. `surface` is the deformed surface; the rest is information for programs.
struct QuantityRequest {
    const TriMesh& surface;
    bool want_sensitivities = false;
    int evaluation = 0;  ///< number of this evaluation within the run, from 1
    int level = 0;
    std::vector<std::pair<std::string, double>> variables;  ///< names and physical values of the shape variables
    /// The same for the parameters (`Problem::program_parameters`, in their order); angles in radians.
    std::vector<std::pair<std::string, double>> parameters = {};
    /// Polled while a program runs; true: end the program and throw Interrupted.
    std::function<bool()> stop_wanted = {};
    /// Polled after that; true: the answer will not be collected later, so cancel queued jobs too.
    std::function<bool()> is_cancelled = {};
    std::string surface_hash = {};  ///< of `surface`; empty: not known
    /// With want_sensitivities: per value, whether its sensitivities are requested; empty: all. A quantity may return
    /// more.
    std::vector<char> wanted = {};

    bool wants(std::size_t value) const { return want_sensitivities && (wanted.empty() || wanted[value]); }
};

struct QuantityResult {
    std::vector<double> values;  ///< one per name; empty after a failure
    std::vector<Points> dJ_dv;   ///< n x 3 per value, 0 rows where not requested; empty without want_sensitivities
    std::optional<Failure> failure;
    /// dJ/d(parameter) per value at fixed shape, in the order of `QuantityRequest::parameters`; empty: depends on the
    /// shape alone. NaN where unknown: taken by finite differences if allowed, else a failure.
    std::vector<Eigen::VectorXd> dJ_dp = {};
    std::vector<std::string> remarks = {};  ///< log messages: failed attempts, a substitute value
    bool is_substitute = false;             ///< the value is the user's substitute for a failed evaluation
};

/// Residuals of a fit, weights included: J = sum of squares of r. Rows are grouped in points of `width` rows
/// each: a point's squared distance is |r of its rows|^2 / weight; a robust loss applies to it.
struct Residuals {
    Eigen::VectorXd r;                                   ///< N, length
    Eigen::SparseMatrix<double, Eigen::RowMajor> dr_dv;  ///< N x 3n; column 3k + c: coordinate c of vertex k
    int width = 1;                                       ///< rows of a point: 3 for a vector, 1 for a number
    Eigen::VectorXd weight;                              ///< N / width, >= 0; sums to 1
};

/// Residuals of `surface`. Closest points are found on `matched`, a surface of the same triangles: `surface` itself
/// gives the true distances, an earlier one keeps its matches. @throws InvalidInput, naming the place, where a residual
/// does not exist or is not finite.
using ResidualFunction = std::function<Residuals(const TriMesh& surface, const TriMesh& matched)>;

/// A number per vertex, for display: a quantity's view of the surface.
struct SurfaceField {
    std::string name;        ///< "aero.cp"
    Eigen::VectorXd values;  ///< n
};

/// A value computed from other values of the same evaluation.
struct Combination {
    std::vector<std::string> of;  ///< values of quantities earlier in the list, or parameters
    /// Value at these, in the order of `of`; sets `gradient` (may be null) to the derivatives by them.
    std::function<double(const Eigen::VectorXd& values, Eigen::VectorXd* gradient)> value;
};

struct Quantity {
    std::vector<std::string> names;  ///< one per value: "volume", or "aero.drag", "aero.lift"
    std::function<QuantityResult(const QuantityRequest&)> evaluate;
    ResidualFunction residuals;  ///< empty: the quantity has none
    bool has_sensitivities = true;
    /// true: a failed evaluation shortens the step and the run continues; false: it ends the run.
    bool failing_shortens_step = false;
    /// Identifies the external program and its arguments. Not empty: an evaluation is expensive and the journal keeps
    /// its answer.
    std::string program = {};
    /// For gradients from a program of their own: `evaluate` without sensitivities returns the values, and this returns
    /// the sensitivities (without values) of the same request later, on demand. Empty: `evaluate` returns both.
    std::function<QuantityResult(const QuantityRequest&)> differentiate = {};
    int parallel = 1;  ///< maximum number of concurrent evaluations of the program, each in its own thread
    std::filesystem::path cache = {};  ///< folder of answers shared by several runs; empty: none
    std::string cache_key = {};        ///< what an answer depends on besides surface and variables
    /// Fields on the request's surface, for reports and ParaView only. Empty: none.
    std::function<std::vector<SurfaceField>(const QuantityRequest&)> fields = {};
    /// Instead of `evaluate`: the single value is computed from others.
    std::optional<Combination> combination = {};
};

}  // namespace strake
