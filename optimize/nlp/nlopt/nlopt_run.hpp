#pragma once
#include "optimize/nlp/program/guard.hpp"

#include <nlopt.hpp>

/// One run of one of NLopt's algorithms. Internal.
namespace strake {

/// The terms that an augmented Lagrangian adds to the objective (in the unit of objective / guard.scale) for the
/// constraints that the method cannot take:  p/2 sum h^2 + l.h  (= p/2 sum (h + l/p)^2 up to a constant) and for
/// inequalities 1/(2p) sum (max(0, m + p g)^2 - m^2).
struct Lagrangian {
    bool inequalities = true, equalities = true;  ///< are in it
    Eigen::VectorXd multipliers;                  ///< per row of the constraints
    double penalty = 1;

    double value(const NonlinearProgram& program, const Evaluation& evaluation) const;
    /// Multipliers after the update by the constraints' values: max(0, m + p g), l + p h.
    Eigen::VectorXd updated(const NonlinearProgram& program, const Evaluation& evaluation) const;
};

/// The box of allowed x around a centre; `radius` in every variable, infinite: the whole bounds.
struct SearchBox {
    Eigen::VectorXd lower, upper;
};
SearchBox box_around(const NonlinearProgram& program, const Eigen::VectorXd& centre, double radius);
/// On a side of the box that is not a bound.
bool lies_on_artificial_side(const NonlinearProgram& program, const SearchBox& box, const Eigen::VectorXd& x);

/// Runs the algorithm of `method` from a start in a box. NLopt sees finite numbers only: a failure stops it or, where
/// the method ranks failures, gives it the worst value so far (a gradient method: a parabola that rises to it).
class NloptRun {
public:
    NloptRun(Guard& guard, const MethodFacts& method, const Lagrangian* lagrangian)
        : guard_(guard), method_(method), lagrangian_(lagrangian) {}

    /// NLopt's code; `guard.cause` says whether the guard ended it.
    nlopt::result run(const Eigen::VectorXd& start, const SearchBox& box, double objective_tolerance,
                      double step_tolerance);

    bool has_lowest() const { return has_lowest_; }

    Eigen::VectorXd end_x;  ///< NLopt's result, or where it was stopped
    Eigen::VectorXd
        lowest_x;  ///< where the value that it minimizes was lowest (violations of its own constraints first)
    Evaluation lowest;
    std::string message;  ///< NLopt's own, when it broke down

private:
    static double objective(unsigned n, const double* z, double* gradient, void* self);
    static void inequalities(unsigned count, double* value, unsigned, const double* z, double* gradient, void* self);
    static void equalities(unsigned count, double* value, unsigned, const double* z, double* gradient, void* self);
    void constraints(int first, unsigned count, double* value, const double* z, double* gradient);
    void configure(nlopt::opt& opt, const SearchBox& box, double objective_tolerance, double step_tolerance);
    void set_steps(nlopt::opt& opt, const SearchBox& box) const;
    void set_whitener(const Eigen::VectorXd& start, const SearchBox& box);
    Eigen::VectorXd point(const double* z) const;  ///< all variables
    void set_population(nlopt::opt& opt) const;
    const Evaluation* evaluation(const double* z, bool gradient);
    double value_of(const Evaluation& evaluation) const;
    Eigen::VectorXd gradient_of(const Evaluation& evaluation) const;
    double failed_value(const double* z, double* gradient) const;
    void keep(const double* z, const Evaluation& evaluation, double value);
    bool passes(bool inequality) const {  ///< to NLopt
        return !lagrangian_ || !(inequality ? lagrangian_->inequalities : lagrangian_->equalities);
    }

    Guard& guard_;
    const MethodFacts& method_;
    const Lagrangian* lagrangian_;
    nlopt::opt* opt_ = nullptr;
    Eigen::MatrixXd whitener_;  ///< free variables = start + whitener z, moved into the box; empty: they are z
    Eigen::VectorXd origin_;
    SearchBox box_;
    double lowest_value_ = 0, lowest_violation_ = 0, worst_ = 0, worst_violation_ = 1;
    bool has_lowest_ = false;
    Eigen::VectorXd good_x_, failed_z_;  ///< last point with a value; last one without, in the free variables
    double good_value_ = 0;
};

}  // namespace strake
