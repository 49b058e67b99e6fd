#include "bench/published/lattice.hpp"

#include "core/error.hpp"
#include "core/fields/invariance.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>

namespace strake::evidence {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double margin = 0.02;     ///< of the box beyond the surface, of its extent, where nothing is held
constexpr double repeated = 1e-10;  ///< of a motion's mean square: less is new, and it is left out

/// Does the surface end at the plane?
bool is_half(const TriMesh& surface, const SymmetryPlane& plane) {
    const VectorXd height = (surface.vertices * plane.normal).array() - plane.offset;
    const double near = 1e-6 * box_diagonal(surface);
    return height.minCoeff() > -near || height.maxCoeff() < near;
}

/// Of vertices that are not held.
Box free_box(const Points& v, const std::vector<char>& held) {
    Box free{Vector3d::Constant(1e300), Vector3d::Constant(-1e300)};
    for (int k = 0; k < v.rows(); ++k)
        if (!held[static_cast<std::size_t>(k)]) {
            free.min = free.min.cwiseMin(v.row(k).transpose());
            free.max = free.max.cwiseMax(v.row(k).transpose());
        }
    return free;
}

/// The same without a margin on sides where held ones or the plane of symmetry are.
Box box_of(const Problem& problem, const std::vector<char>& held) {
    const Points& v = problem.surface.vertices;
    const Box free = free_box(v, held);
    Box box = free;
    const Vector3d extra = margin * (free.max - free.min);
    for (int c = 0; c < 3; ++c) {
        const double near = 1e-9 * box_diagonal(problem.surface);
        double below = -1e300, above = 1e300;  // the held vertices next to it
        for (int k = 0; k < v.rows(); ++k) {
            if (!held[static_cast<std::size_t>(k)]) continue;
            if (v(k, c) <= free.min[c] + near) below = std::max(below, v(k, c));
            if (v(k, c) >= free.max[c] - near) above = std::min(above, v(k, c));
        }
        const bool is_plane = problem.symmetry && std::abs(problem.symmetry->normal[c]) > 0.999;
        box.min[c] = below > -1e300 ? below : free.min[c] - (is_plane ? 0 : extra[c]);
        box.max[c] = above < 1e300 ? above : free.max[c] + (is_plane ? 0 : extra[c]);
    }
    return box;
}

VectorXd weight(const Points& v, const Box& box, const std::array<int, 3>& points, const std::array<int, 3>& at) {
    VectorXd column = VectorXd::Ones(v.rows());
    for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c);
        const double length = box.max[c] - box.min[c];
        if (points[k] == 1 || length <= 0) continue;
        for (Eigen::Index row = 0; row < v.rows(); ++row)
            column[row] *= b_spline(points[k], at[k], std::clamp((v(row, c) - box.min[c]) / length, 0.0, 1.0));
    }
    return column;
}

class Motions {
public:
    Motions(const Problem& problem, const LatticeBox& box)
        : problem_(problem), held_(held_vertices(problem)), area_(vertex_areas(problem.surface)) {
        area_ /= area_.sum();
        for (const char letter : box.moves)
            if (letter < 'x' || letter > 'z') throw InvalidInput(text("direction '", letter, "': expected x, y or z"));
        const Box around = box_of(problem, held_);
        for (int i = 0; i < box.points[0]; ++i)
            for (int j = 0; j < box.points[1]; ++j)
                for (int k = 0; k < box.points[2]; ++k) {
                    const VectorXd w = weight(problem.surface.vertices, around, box.points, {i, j, k});
                    if (moves_what_is_held(w)) continue;
                    for (const char letter : box.moves) add(w, letter - 'x');
                }
        if (columns_.empty()) throw InvalidInput("no point of the box moves anything");
    }

    /// 3 n x variables, vertex after vertex; each with a largest displacement of `step`.
    MatrixXd matrix(double step) const {
        MatrixXd all(3 * problem_.surface.num_vertices(), static_cast<Eigen::Index>(columns_.size()));
        for (std::size_t j = 0; j < columns_.size(); ++j) {
            const Points& motion = columns_[j];
            const double largest = motion.rowwise().norm().maxCoeff();
            for (Eigen::Index v = 0; v < motion.rows(); ++v)
                all.col(static_cast<Eigen::Index>(j)).segment<3>(3 * v) = step / largest * motion.row(v).transpose();
        }
        return all;
    }
    const VectorXd& area() const { return area_; }

private:
    bool moves_what_is_held(const VectorXd& w) const {
        for (Eigen::Index v = 0; v < w.size(); ++v)
            if (held_[static_cast<std::size_t>(v)] && w[v] > 1e-9) return true;
        return false;
    }

    void add(const VectorXd& w, int direction) {
        const TriMesh& surface = problem_.surface;
        if (problem_.symmetry && is_half(surface, *problem_.symmetry) &&
            std::abs(problem_.symmetry->normal[direction]) > 1e-9) {
            const VectorXd height = (surface.vertices * problem_.symmetry->normal).array() - problem_.symmetry->offset;
            for (Eigen::Index v = 0; v < w.size(); ++v)
                if (std::abs(height[v]) < 1e-6 * box_diagonal(surface) && w[v] > 1e-9) return;
        }
        Points motion = Points::Zero(w.size(), 3);
        motion.col(direction) = w;
        if (problem_.parameters.invariance) motion = problem_.parameters.invariance->projected(motion);
        for (Eigen::Index v = 0; v < w.size(); ++v)  // its mean over a class could reach what is held
            if (held_[static_cast<std::size_t>(v)]) motion.row(v).setZero();
        Points left = motion;
        const double all = product(motion, motion);
        for (int twice = 0; twice < 2; ++twice)
            for (const Points& unit : orthonormal_) left -= product(unit, left) * unit;
        const double is_new = product(left, left);
        if (!(all > 1e-20) || is_new < repeated * all) return;
        columns_.push_back(motion);
        orthonormal_.push_back(left / std::sqrt(is_new));
    }

    double product(const Points& a, const Points& b) const { return area_.dot(a.cwiseProduct(b).rowwise().sum()); }

    const Problem& problem_;
    const std::vector<char> held_;
    VectorXd area_;
    std::vector<Points> columns_, orthonormal_;
};

}  // namespace

ComparedMotion lattice_box(const Problem& problem, const LatticeBox& box) {
    if (*std::min_element(box.points.begin(), box.points.end()) < 1)
        throw InvalidInput("a box has at least one point along each axis");
    const Motions motions(problem, box);
    const double step = problem.parameters.max_displacement * box_diagonal(problem.surface);
    const MatrixXd W = motions.matrix(step);
    MatrixXd moved = 2 / step * W;
    for (Eigen::Index v = 0; v < motions.area().size(); ++v) moved.middleRows(3 * v, 3) *= std::sqrt(motions.area()[v]);
    MatrixXd square = moved.transpose() * moved;
    square.diagonal() *= 1 + 1e-9;
    ComparedMotion motion;
    motion.name = text("box_", box.points[0], "x", box.points[1], "x", box.points[2]);
    motion.lower = VectorXd::Constant(W.cols(), -1);
    motion.upper = VectorXd::Constant(W.cols(), 1);
    motion.weight = square.diagonal().cwiseSqrt();
    motion.metric = motion.weight.cwiseInverse().asDiagonal() * square * motion.weight.cwiseInverse().asDiagonal();
    motion.vertices = [W, rest = problem.surface.vertices](const VectorXd& x) {
        Points v = rest;
        const VectorXd by = W * x;
        for (Eigen::Index k = 0; k < v.rows(); ++k) v.row(k) += by.segment<3>(3 * k).transpose();
        return v;
    };
    motion.gradient = [W](const VectorXd&, const Points& dJ_dv) {
        VectorXd flat(W.rows());
        for (Eigen::Index k = 0; k < dJ_dv.rows(); ++k) flat.segment<3>(3 * k) = dJ_dv.row(k).transpose();
        return VectorXd(W.transpose() * flat);
    };
    return motion;
}

}  // namespace strake::evidence
