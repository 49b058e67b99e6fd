#pragma once
#include "core/error.hpp"
#include "optimize/nlp/minimizer.hpp"
#include "optimize/nlp/program/finite_differences.hpp"
#include "optimize/nlp/program/methods.hpp"

#include <memory>

/// Small nonlinear programs with known optima, and faults to put into them.
namespace strake {

struct KnownProgram {
    const char* name;
    NonlinearProgram program;
    Eigen::VectorXd optimum;
    double value;
};

inline Eigen::VectorXd vec(std::initializer_list<double> v) {
    return Eigen::Map<const Eigen::VectorXd>(v.begin(), static_cast<Eigen::Index>(v.size()));
}

using Values = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;  ///< objective, then constraints
using Slopes = std::function<Eigen::MatrixXd(const Eigen::VectorXd&)>;  ///< a row each

inline NonlinearProgram program_of(const Eigen::VectorXd& start, const Eigen::VectorXd& lower,
                                   const Eigen::VectorXd& upper, int inequalities, int equalities, const Values& values,
                                   const Slopes& slopes) {
    NonlinearProgram p;
    p.start = start;
    p.lower = lower;
    p.upper = upper;
    p.num_inequalities = inequalities;
    p.num_equalities = equalities;
    p.evaluate = [=](const Eigen::VectorXd& x) {
        const Eigen::VectorXd v = values(x);
        Evaluation s;
        s.objective = v[0];
        s.constraints = v.tail(v.size() - 1);
        return s;
    };
    p.differentiate = [=](const Eigen::VectorXd& x, Evaluation& s) {
        const Eigen::MatrixXd all = slopes(x);
        s.gradient = all.row(0).transpose();
        s.jacobian = all.bottomRows(all.rows() - 1);
    };
    return p;
}

inline KnownProgram bowl() {
    static const Eigen::VectorXd at = vec({0.4, -0.3, 0.2}), weight = vec({1, 10, 50});
    return {
        "bowl",
        program_of(
            vec({-0.5, 0.8, -0.9}), Eigen::VectorXd::Constant(3, -1), Eigen::VectorXd::Constant(3, 1), 0, 0,
            [](const Eigen::VectorXd& x) { return vec({1 + (x - at).cwiseAbs2().dot(weight)}); },
            [](const Eigen::VectorXd& x) { return Eigen::MatrixXd(2 * (x - at).cwiseProduct(weight).transpose()); }),
        at, 1};
}

inline KnownProgram rosenbrock() {
    return {"rosenbrock",
            program_of(
                vec({-1.2, 1}), vec({-2, -2}), vec({2, 2}), 0, 0,
                [](const Eigen::VectorXd& x) {
                    return vec({1 + 100 * std::pow(x[1] - x[0] * x[0], 2) + std::pow(1 - x[0], 2)});
                },
                [](const Eigen::VectorXd& x) {
                    Eigen::MatrixXd g(1, 2);
                    g << -400 * x[0] * (x[1] - x[0] * x[0]) - 2 * (1 - x[0]), 200 * (x[1] - x[0] * x[0]);
                    return g;
                }),
            vec({1, 1}), 1};
}

/// Problem 71 of Hock & Schittkowski (1981); product as inequality, sum of squares as equality.
inline KnownProgram hock_schittkowski_71() {
    return {
        "hs71",
        program_of(
            vec({1, 5, 5, 1}), Eigen::VectorXd::Constant(4, 1), Eigen::VectorXd::Constant(4, 5), 1, 1,
            [](const Eigen::VectorXd& x) {
                return vec({x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2], 1 - x.prod() / 25, x.squaredNorm() / 40 - 1});
            },
            [](const Eigen::VectorXd& x) {
                Eigen::MatrixXd g(3, 4);
                g.row(0) << x[3] * (2 * x[0] + x[1] + x[2]), x[0] * x[3], x[0] * x[3] + 1, x[0] * (x[0] + x[1] + x[2]);
                g.row(1) = -x.prod() / 25 * x.cwiseInverse().transpose();
                g.row(2) = x.transpose() / 20;
                return g;
            }),
        vec({1, 4.7429996, 3.8211500, 1.3794083}), 17.0140173};
}

/// Rastrigin's function about (0.7, -1.3): about a hundred local minima.
inline KnownProgram rastrigin() {
    const Eigen::VectorXd at = vec({0.7, -1.3});
    return {"rastrigin",
            program_of(
                vec({3.9, 3.2}), vec({-5, -5}), vec({5, 5}), 0, 0,
                [=](const Eigen::VectorXd& x) {
                    const Eigen::ArrayXd d = (x - at).array();
                    return vec({21 + (d.square() - 10 * (2 * M_PI * d).cos()).sum()});
                },
                [=](const Eigen::VectorXd& x) {
                    const Eigen::ArrayXd d = (x - at).array();
                    return Eigen::MatrixXd((2 * d + 20 * M_PI * (2 * M_PI * d).sin()).matrix().transpose());
                }),
            at, 1};
}

/// The least value lies in a corner of the bounds.
inline KnownProgram corner() {
    const Eigen::VectorXd slope = vec({-1, 2, -3});
    return {"corner",
            program_of(
                vec({0.5, 0.5, 0.5}), Eigen::VectorXd::Zero(3), Eigen::VectorXd::Ones(3), 0, 0,
                [=](const Eigen::VectorXd& x) { return vec({10 + slope.dot(x)}); },
                [=](const Eigen::VectorXd&) { return Eigen::MatrixXd(slope.transpose()); }),
            vec({1, 0, 1}), 6};
}

inline MinimizeOptions tight_options(Method method, int evaluations) {
    MinimizeOptions o;
    o.method = method;
    o.max_evaluations = evaluations;
    o.objective_tolerance = 1e-10;
    o.step_tolerance = 1e-8;
    return o;
}

/// For the names of parameterized tests.
inline std::string method_name(const MethodFacts& facts) { return facts.name; }

}  // namespace strake
