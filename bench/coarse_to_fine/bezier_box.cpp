#include "bench/coarse_to_fine/comparators.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace strake::evidence {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int max_points = 11;
constexpr double margin = 0.02;  ///< of the box beyond the surface, of its extent

struct Lattice {
    std::array<int, 3> points{2, 2, 2};
    bool is_spline =
        false;  ///< cubic B-splines (of lower degree on fewer than four points), else Bernstein polynomials
    bool held_low = false, held_high = false;  ///< layers on the sides of the held axis
    int axis = 0;

    int variables() const {
        int count = 3;
        for (int c = 0; c < 3; ++c) count *= points[c] - (c == axis ? int(held_low) + int(held_high) : 0);
        return count;
    }
};

/// The box of what moves; on held sides it ends at the last held vertex.
Box moving_box(const EvidenceProblem& problem, const std::vector<char>& held) {
    const Points& v = problem.problem.surface.vertices;
    Box box{Vector3d::Constant(1e300), Vector3d::Constant(-1e300)};
    for (int k = 0; k < v.rows(); ++k)
        if (!held[k]) {
            box.min = box.min.cwiseMin(v.row(k).transpose());
            box.max = box.max.cwiseMax(v.row(k).transpose());
        }
    const Vector3d extra = margin * (box.max - box.min);
    box.min -= extra;
    box.max += extra;
    const int axis = problem.ends.axis;
    for (const bool low : {true, false}) {
        if (!(low ? problem.ends.low : problem.ends.high)) continue;
        const double plane = low ? *problem.ends.low : *problem.ends.high;
        double last = plane;
        for (int k = 0; k < v.rows(); ++k) {
            const bool this_end = low ? v(k, axis) < plane + 0.5 * (box.max - box.min)[axis]
                                      : v(k, axis) > plane - 0.5 * (box.max - box.min)[axis];
            if (held[k] && this_end) last = low ? std::max(last, v(k, axis)) : std::min(last, v(k, axis));
        }
        (low ? box.min : box.max)[axis] = last;
    }
    return box;
}

Lattice choose_lattice(const EvidenceProblem& problem, const Box& box, int variables) {
    const Vector3d extent = box.max - box.min;
    Lattice best;
    double best_score = std::numeric_limits<double>::infinity();
    for (int i = 2; i <= max_points; ++i)
        for (int j = 2; j <= max_points; ++j)
            for (int k = 2; k <= max_points; ++k) {
                Lattice lattice{
                    {i, j, k}, false, problem.ends.low.has_value(), problem.ends.high.has_value(), problem.ends.axis};
                if (lattice.variables() <= 0) continue;
                const double off = std::abs(std::log(double(lattice.variables()) / variables));
                Vector3d spacing(extent[0] / (i - 1), extent[1] / (j - 1), extent[2] / (k - 1));
                spacing = spacing.array().log();
                const double uneven = (spacing.array() - spacing.mean()).matrix().norm();
                const double score = uneven + (off > 0.03 ? 1e3 * off : 0);
                if (score < best_score) best_score = score, best = lattice;
            }
    return best;
}

double bernstein(int degree, int i, double u) {
    double binomial = 1;
    for (int k = 0; k < i; ++k) binomial *= double(degree - k) / (k + 1);
    return binomial * std::pow(u, i) * std::pow(1 - u, degree - i);
}

/// Weight of control point `at` at every vertex; held vertices have none.
VectorXd weight(const Points& v, const Box& box, const Lattice& lattice, const std::array<int, 3>& at,
                const std::vector<char>& held) {
    VectorXd column = VectorXd::Zero(v.rows());
    for (int row = 0; row < v.rows(); ++row) {
        if (held[row]) continue;
        column[row] = 1;
        for (int c = 0; c < 3; ++c) {
            const double u = (v(row, c) - box.min[c]) / (box.max[c] - box.min[c]);
            const double inside = std::clamp(u, 0.0, 1.0);
            column[row] *= lattice.is_spline ? b_spline(lattice.points[c], at[c], inside)
                                             : bernstein(lattice.points[c] - 1, at[c], inside);
        }
    }
    return column;
}

/// Column j: weight of free control point j at every vertex.
MatrixXd weights(const EvidenceProblem& problem, const Box& box, const Lattice& lattice,
                 const std::vector<char>& held) {
    const Points& v = problem.problem.surface.vertices;
    std::vector<VectorXd> columns;
    for (int i = 0; i < lattice.points[0]; ++i)
        for (int j = 0; j < lattice.points[1]; ++j)
            for (int k = 0; k < lattice.points[2]; ++k) {
                const std::array<int, 3> at{i, j, k};
                const int layer = at[lattice.axis], last = lattice.points[lattice.axis] - 1;
                if ((lattice.held_low && layer == 0) || (lattice.held_high && layer == last)) continue;
                columns.push_back(weight(v, box, lattice, at, held));
            }
    MatrixXd result(v.rows(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t j = 0; j < columns.size(); ++j) result.col(static_cast<Eigen::Index>(j)) = columns[j];
    return result;
}

}  // namespace

double b_spline(int points, int i, double u) {
    const int degree = std::min(3, points - 1), spans = points - degree;
    const auto knot = [&](int k) { return std::clamp(k - degree, 0, spans) / double(spans); };
    std::array<double, 4> value{};  // of splines i to i + degree, of rising degree
    for (int k = 0; k <= degree; ++k) {
        const bool is_last = knot(i + k + 1) == 1 && u == 1 && knot(i + k) < 1;
        value[static_cast<std::size_t>(k)] = (knot(i + k) <= u && u < knot(i + k + 1)) || is_last ? 1 : 0;
    }
    for (int d = 1; d <= degree; ++d)
        for (int k = 0; k <= degree - d; ++k) {
            const auto at = static_cast<std::size_t>(k);
            const double up = knot(i + k + d) - knot(i + k), down = knot(i + k + d + 1) - knot(i + k + 1);
            value[at] = (up > 0 ? (u - knot(i + k)) / up * value[at] : 0) +
                        (down > 0 ? (knot(i + k + d + 1) - u) / down * value[at + 1] : 0);
        }
    return value[0];
}

std::vector<char> held_vertices(const Problem& problem) {
    std::vector<char> held(problem.surface.num_vertices(), 0);
    for (const int t : problem.fixed)
        for (int k = 0; k < 3; ++k) held[problem.surface.triangles(t, k)] = 1;
    return held;
}

namespace {

ComparedMotion motion_of(const EvidenceProblem& problem, const Box& box, const Lattice& lattice) {
    const TriMesh& surface = problem.problem.surface;
    const std::vector<char> held = held_vertices(problem.problem);
    const MatrixXd all = weights(problem, box, lattice, held);
    const VectorXd largest = all.colwise().maxCoeff();
    std::vector<Eigen::Index> kept;
    for (Eigen::Index j = 0; j < all.cols(); ++j)
        if (largest[j] > 1e-9 * largest.maxCoeff()) kept.push_back(j);
    const double step = problem.problem.parameters.max_displacement * box_diagonal(surface);
    MatrixXd W = all(Eigen::all, kept);  // displacement at x = 1, per component
    for (Eigen::Index j = 0; j < W.cols(); ++j) W.col(j) *= step / largest[kept[static_cast<std::size_t>(j)]];

    const VectorXd area = vertex_areas(surface);
    const MatrixXd moved = 2 / step * ((area / area.sum()).cwiseSqrt().asDiagonal() * W);
    MatrixXd square = moved.transpose() * moved;
    square.diagonal() *= 1 + 1e-9;
    const VectorXd root = square.diagonal().cwiseSqrt();
    const MatrixXd scaled = root.cwiseInverse().asDiagonal() * square * root.cwiseInverse().asDiagonal();
    const Eigen::Index n = W.cols();
    ComparedMotion motion;
    motion.name = text(lattice.points[0], "x", lattice.points[1], "x", lattice.points[2]);
    motion.lower = VectorXd::Constant(3 * n, -1);
    motion.upper = VectorXd::Constant(3 * n, 1);
    motion.weight.resize(3 * n);
    motion.metric = MatrixXd::Zero(3 * n, 3 * n);
    for (int c = 0; c < 3; ++c) {
        motion.weight.segment(c * n, n) = root;
        motion.metric.block(c * n, c * n, n, n) = scaled;
    }
    motion.vertices = [W, n, rest = surface.vertices](const VectorXd& x) {
        Points v = rest;
        for (int c = 0; c < 3; ++c) v.col(c) += W * x.segment(c * n, n);
        return v;
    };
    motion.gradient = [W, n](const VectorXd&, const Points& dJ_dv) {
        VectorXd g(3 * n);
        for (int c = 0; c < 3; ++c) g.segment(c * n, n) = W.transpose() * dJ_dv.col(c);
        return g;
    };
    return motion;
}

}  // namespace

ComparedMotion bezier_box(const EvidenceProblem& problem, int variables) {
    const Box box = moving_box(problem, held_vertices(problem.problem));
    return motion_of(problem, box, choose_lattice(problem, box, variables));
}

ComparedMotion spline_lattice(const EvidenceProblem& problem, std::array<int, 3> points) {
    const Box box = moving_box(problem, held_vertices(problem.problem));
    const Vector3d extent = box.max - box.min;
    std::array<int, 3> order{0, 1, 2};  // the longest side first
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return extent[a] > extent[b]; });
    std::sort(points.rbegin(), points.rend());
    Lattice lattice{{}, true, problem.ends.low.has_value(), problem.ends.high.has_value(), problem.ends.axis};
    for (std::size_t c = 0; c < 3; ++c) lattice.points[static_cast<std::size_t>(order[c])] = points[c];
    // A layer on every held side, and one that moves.
    int& across = lattice.points[static_cast<std::size_t>(lattice.axis)];
    across = std::max(across, 1 + int(lattice.held_low) + int(lattice.held_high));
    return motion_of(problem, box, lattice);
}

}  // namespace strake::evidence
