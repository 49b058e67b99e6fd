#pragma once
#include "bench/coarse_to_fine/problems.hpp"

#include <array>

/// What users have today in place of Strake's variables: motions of the vertices by a box or a filter.
namespace strake::evidence {

/// v(x) = rest + B x, but for boxes that twist. Units, bounds and metric follow the rules of Strake's own design space:
/// a variable's unit moves the surface by max_displacement at x = 1, bounds are [-1, 1], and the metric is that of the
/// mean square response.
struct ComparedMotion {
    std::string name;
    Eigen::VectorXd lower, upper;
    Eigen::VectorXd weight;  ///< root of the metric's diagonal: the optimizer works in y = weight * x
    Eigen::MatrixXd metric;  ///< of y; empty: the identity
    std::function<Points(const Eigen::VectorXd& x)> vertices;
    std::function<Eigen::VectorXd(const Eigen::VectorXd& x, const Points& dJ_dv)> gradient;  ///< (dv/dx)^T dJ/dv
    int size() const { return static_cast<int>(lower.size()); }
};

/// B-spline i of `points` of degree min(3, points - 1) on clamped, even knots over [0, 1], at u (Cox and de Boor).
double b_spline(int points, int i, double u);

/// Bezier volume (free-form deformation: Sederberg and Parry 1986; in SU2 and pyGeo) about what is not held. Vertices
/// move with the Bernstein polynomials of their place in the box. The layer of control points on every side of the box
/// that faces a held end is held, so what is held stays and the surface stays continuous. The lattice is the one of at
/// most 11 points a side with the number of variables nearest to `variables` (within 3 % where there is one), then with
/// the most even spacing. Control points that move nothing are left out.
ComparedMotion bezier_box(const EvidenceProblem& problem, int variables);

/// The lattice that is usual with solvers and that a user sets by hand: so many control points along the sides of the
/// same box, most along its longest side, with cubic B-splines on clamped even knots (of degree 1 on two points); held
/// layers as above.
ComparedMotion spline_lattice(const EvidenceProblem& problem, std::array<int, 3> points);

/// Every vertex that is not held, moved through a Helmholtz filter (vertex morphing as in Kratos; Lazarov and
/// Sigmund 2011): (M + r^2 K) u = M s for every component with u = 0 where held, M the lumped mass and K the stiffness
/// matrix of linear elements, r = R / (2 sqrt 3), R the mean diameter of a patch of the last level. s is a vector for
/// problems with vector loads or strains (three variables a vertex), along the vertex normal otherwise. The filter is
/// the method's own metric: the variables are scaled, not whitened, which would undo it.
ComparedMotion filtered_vertices(const EvidenceProblem& problem);

/// Per vertex: belongs to a held triangle.
std::vector<char> held_vertices(const Problem& problem);

}  // namespace strake::evidence
