#pragma once
#include "casefile/model/case.hpp"
#include "studio/linear_preview.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

/// The shapes that a case can make, one at a time, as its sliders are moved: the very evaluation of `strake sweep`.
namespace strake {

struct BenchVariable {
    std::string name;
    double lower = 0, upper = 0;  ///< scaled: 1 moves the surface by the variable scale
    double unit = 1;              ///< physical value at 1
    bool is_parameter = false;    ///< of a program; moves nothing
};

struct BenchShape {
    std::string status, reason;  ///< "ok", or what the guard or the solver says
    Points vertices;             ///< empty: there is no shape
    std::vector<std::string> names;
    std::vector<double> values;  ///< of built-in quantities
};

class ShapeBench {
public:
    /// Builds the problem. Programs, plug-ins and Python quantities are left out, and with them all that may depend on
    /// them: objective, constraints and formulas.
    /// @throws as build_problem.
    explicit ShapeBench(Case the_case);
    ~ShapeBench();

    int coarsest() const;  ///< 0 with displacement fields, else 1
    int finest() const;
    bool leaves_out_programs() const;
    /// The variables of a level, of the shape. @throws InvalidInput: no such level; whatever a run throws at its start.
    const std::vector<BenchVariable>& variables(int level);
    /// The shape where variable i of the level is x[i]. @throws InvalidInput: another number of values, or not finite,
    /// or outside of [lower, upper].
    /// @param deformed is told the shape before the guard and the quantities look at it, valid or not; twice, where the
    /// first equilibrium found is not a valid one. False: they need not look, the status is "overtaken".
    BenchShape at(int level, const std::vector<double>& x, const std::function<bool(const Points&)>& deformed = {});
    /// What the variables of a level do to first order, begun when it is asked for the first time.
    std::shared_ptr<const LinearPreview> preview(int level);
    /// The objective and its derivative by the vertices of a shape (n x 3), downhill: where the surface is to go for a
    /// better value. Empty: the case has no objective whose derivative needs no program. @throws InvalidInput.
    struct Slope {
        std::string name, trouble;
        Points downhill;
    };
    Slope slope(const Points& vertices);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace strake
