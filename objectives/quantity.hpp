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

/// The one interface of everything that can be optimized or constrained: built-in measures and other
/// people's programs alike. A quantity gives one or more values and, when asked, their exact vertex sensitivities.
namespace strake {

/// Why there is no value. Failing is a result, never an exception and never a number.
struct Failure {
    std::string kind;     ///< one word: spawn, exit, signal, timeout, no_result, unreadable, missing_key, wrong_type,
                          ///< not_finite, wrong_count, undefined, exception
    std::string message;  ///< where, what, expected; for a program with the last lines of its log
};

/// Thrown where the user wants to stop: the evaluation is no failure, it has no end. Not a std::exception, so that
/// nothing takes it for one.
struct Interrupted {
    std::vector<std::string> going_on = {};  ///< jobs that stay in a queue, in words
};

/// A call of a program that somebody else makes.
struct AwaitedCall {
    std::string quantity;
    int evaluation = 0;
    std::string folder;                ///< with the surface
    std::string request;               ///< file in it
    std::vector<std::string> command;  ///< as it would be run, there
};
/// Thrown, as Interrupted, where these have no answer yet.
struct Awaited {
    std::vector<AwaitedCall> calls;
};

/// What is to be evaluated. `surface` is the deformed surface; the rest is for programs that want to know.
struct QuantityRequest {
    const TriMesh& surface;
    bool want_sensitivities = false;
    int evaluation = 0;  ///< number of this evaluation within the run, from 1
    int level = 0;
    std::vector<std::pair<std::string, double>> variables;  ///< names and physical values of the shape variables
    /// The same of the case's own variables (`Problem::own`, in their order): angles in radians.
    std::vector<std::pair<std::string, double>> own = {};
    /// Asked while a program runs; true: end the program and throw Interrupted.
    std::function<bool()> stop_wanted = {};
    /// Asked then: true: nobody will come back for the answer, so that jobs in a queue are cancelled, too.
    std::function<bool()> is_given_up = {};
    std::string surface_hash = {};  ///< of `surface`; empty: not known
    /// With want_sensitivities, per value whether its own are wanted; empty: all. A quantity may give more.
    std::vector<char> wanted = {};

    bool wants(std::size_t value) const { return want_sensitivities && (wanted.empty() || wanted[value]); }
};

struct QuantityResult {
    std::vector<double> values;  ///< one per name; empty after a failure
    std::vector<Points> dJ_dv;   ///< n x 3 per value, 0 rows where not wanted; empty when not asked for
    std::optional<Failure> failure;
    /// dJ/d(own variable) per value, at fixed shape, in the order of `QuantityRequest::own`; empty: depends on the
    /// shape alone. NaN where it is not known: by differences, if these are allowed, else a failure.
    std::vector<Eigen::VectorXd> dJ_down = {};
    std::vector<std::string> remarks = {};  ///< for the log: failed attempts, a value that stands for a failure
    bool stands_for_failure = false;        ///< no answer, but what the user wants instead of none
};

/// Residuals of a fit, with the weights in them: J = sum of squares of r. Rows are grouped in points of `width` rows
/// each: the square of a point's distance is |r of its rows|^2 / weight of the point, which is what a robust loss sees.
struct Residuals {
    Eigen::VectorXd r;                                   ///< N, length
    Eigen::SparseMatrix<double, Eigen::RowMajor> dr_dv;  ///< N x 3n; column 3k + c: coordinate c of vertex k
    int width = 1;                                       ///< rows of a point: 3 for a vector, 1 for a number
    Eigen::VectorXd weight;                              ///< N / width, >= 0; sums to 1
};

/// The residuals of `surface`. What is closest to what is looked for on `matched`, a surface of the same triangles:
/// the same one for the true distances, an earlier one to keep the matches. @throws InvalidInput, naming the place,
/// where there are no residuals or one is not finite.
using ResidualFunction = std::function<Residuals(const TriMesh& surface, const TriMesh& matched)>;

/// A number for each vertex, to be looked at: what a quantity sees there.
struct SurfaceField {
    std::string name;        ///< "aero.cp"
    Eigen::VectorXd values;  ///< n
};

/// How a value follows from other values of the same evaluation.
struct Combination {
    std::vector<std::string> of;  ///< values of quantities further up in the list, or own variables
    /// At these values, in the order of `of`; `gradient` (maybe null) becomes the derivatives by them.
    std::function<double(const Eigen::VectorXd& values, Eigen::VectorXd* gradient)> value;
};

struct Quantity {
    std::vector<std::string> names;  ///< one per value: "volume", or "aero.drag", "aero.lift"
    std::function<QuantityResult(const QuantityRequest&)> evaluate;
    ResidualFunction residuals;  ///< empty where the quantity has none
    bool has_sensitivities = true;
    /// A failed evaluation is a step too far, after which a run goes on; else it ends the run.
    bool failing_shortens_step = false;
    /// What identifies the program that is run, with its arguments. Not empty: an evaluation is dear, a journal keeps
    /// what it gave.
    std::string program = {};
    /// Where gradients cost a program of their own: `evaluate` of a request that wants none gives the values, and this
    /// the sensitivities (without values) of the same request, later, if anybody asks. Empty: `evaluate` gives both.
    std::function<QuantityResult(const QuantityRequest&)> differentiate = {};
    int parallel = 1;  ///< of a program: so many evaluations of it may run at the same time, each in its own thread
    std::filesystem::path cache = {};  ///< folder of answers that several runs share; empty: none
    std::string cache_key = {};        ///< what an answer depends on beside surface and variables
    /// What it sees on the request's surface, point by point, for reports and ParaView: no part of a search. Empty
    /// where there is nothing to show.
    std::function<std::vector<SurfaceField>(const QuantityRequest&)> fields = {};
    /// Instead of `evaluate`: the one value is made of others.
    std::optional<Combination> combination = {};
};

}  // namespace strake
