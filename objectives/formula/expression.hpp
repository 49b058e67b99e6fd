#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

/// Arithmetic of named numbers, with exact derivatives.
namespace strake {

/// A formula as "0.7 * cruise.drag / cruise.lift + 0.3 * sqrt(dash.drag)".
///   numbers (1, 0.5, 2e-3), names, pi, + - * / ^ ( )          ^ binds strongest and from the right: -2^2^3 =
///   -(2^(2^3)) sqrt exp log log10 sin cos tan asin acos atan tanh abs      of one argument; angles in radians min max
///   of two or more arguments softmin(w, a, b, ...) softmax(w, a, b, ...)                a smooth bound: -w log sum
///   exp(-a/w), which lies below
///                                                              min by at most w log(count); w > 0
/// A name holds letters, digits, '_', '.' and, where such a name is known, '-'.
/// Smooth except at the kinks of abs, min and max (the first of equal arguments gives the derivative; abs has
/// derivative 0 at 0). Where a function is undefined (log of a negative number) the value is not finite.
class Expression {
public:
    /// @param known names that the formula may use. @throws InvalidInput with the column (from 1) and what was
    /// expected; formulas longer than 10 000 characters or nested deeper than 100.
    Expression(const std::string& formula, const std::vector<std::string>& known);

    const std::vector<std::string>& names() const { return names_; }  ///< names used, in order of first use

    /// @param values of names() @param gradient may be null; set to the derivatives by them (forward mode)
    double value(const Eigen::VectorXd& values, Eigen::VectorXd* gradient = nullptr) const;

private:
    struct Parser;
    enum class Op {
        number,
        name,
        add,
        subtract,
        multiply,
        divide,
        power,
        negate,
        square_root,
        exponential,
        logarithm,
        logarithm10,
        sine,
        cosine,
        tangent,
        arc_sine,
        arc_cosine,
        arc_tangent,
        hyperbolic_tangent,
        absolute,
        minimum,
        maximum,
        soft_minimum,
        soft_maximum
    };
    struct Step {
        Op op;
        double number = 0;  ///< of a number
        int count = 0;      ///< place of a name; number of arguments
    };
    std::vector<Step> steps_;  ///< reverse Polish
    std::vector<std::string> names_;
    friend struct ExpressionStack;
};

}  // namespace strake
