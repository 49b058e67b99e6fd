#include "core/planform/kept_sections.hpp"

#include "core/error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace strake {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int max_iterations = 40;
constexpr double edge_tolerance = 1e-11;  ///< of the chord
constexpr double near_enough = 1e-9;      ///< likewise, where rounding ends the descent
constexpr double told_apart = 1e-7;       ///< likewise: edges that jump between the points of a coarse nose
constexpr double slow = 0.3;              ///< of what is left by a step: a new tangent pays

VectorXd flat(const Points& points) { return Eigen::Map<const VectorXd>(points.data(), points.size()); }

InvalidInput no_section(const Wing& wing, double place) {
    return InvalidInput(
        text("wing '", wing.declaration().name, "' has no section at ", 100 * place, " % of its semispan"));
}

Points points(const VectorXd& flat) { return Eigen::Map<const Points>(flat.data(), flat.size() / 3, 3); }

/// Rows of M: of edges that were measured, or as another matrix has them.
struct EdgeRows {
    std::vector<Eigen::Triplet<double>> entries = {};

    /// @param freedom null: 1
    void add(int knot, const PlanePoint& edge, const VectorXd* freedom) {
        for (int c = 0; knot >= 0 && c < 2; ++c)
            for (const auto& [coordinate, slope] : (c == 0 ? edge.x : edge.z).slope)
                entries.emplace_back(2 * knot + c, coordinate, slope * (freedom ? (*freedom)[coordinate / 3] : 1));
    }
    void copy(int knot, const Eigen::SparseMatrix<double, Eigen::RowMajor>& from) {
        for (int c = 0; knot >= 0 && c < 2; ++c)
            for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(from, 2 * knot + c); it; ++it)
                entries.emplace_back(2 * knot + c, static_cast<int>(it.col()), it.value());
    }
};

/// Chords of the sections of both numbers of each knot.
template <class Sections>
VectorXd chords_of(const Sections& sections, int num_knots) {
    VectorXd chord(2 * num_knots);
    for (const auto& section : sections)
        for (const int knot : {section.leading, section.trailing})
            if (knot >= 0) chord.segment<2>(2 * knot).setConstant(section.chord);
    return chord;
}

void mark_left(const VectorXd& left, const VectorXd& chord, std::vector<char>& marks) {
    for (std::size_t k = 0; k < marks.size(); ++k) {
        const auto first = 2 * static_cast<Eigen::Index>(k);
        if (left.segment<2>(first).norm() > told_apart * chord[first]) marks[k] = 1;
    }
}

}  // namespace

Points KeptSections::in_planes(const Points& motion) const {
    Points result = motion;
    for (Eigen::Index v = 0; v < motion.rows(); ++v)
        result.row(v) -= across_.row(v).dot(motion.row(v)) * across_.row(v);
    return result;
}

Points KeptSections::held(const Points& free) const { return freedom_.asDiagonal() * free; }

/// How far the edges are from where the start has them. Corners of a trailing edge are points of the surface, known
/// from the start, so that it does not jump from one corner to another; in planes that stay they move linearly. So do
/// noses of too few points for a polynomial, and those that jump so that no step brings them back.
/// @param free before `held`: what is taken out of noses that keep their shape
VectorXd KeptSections::off(const TriMesh& surface, const Points& free, const std::vector<char>& is_linear) const {
    VectorXd found = at_start_->edges * flat(free);
    for (const Section& section : sections_) {
        if (section.leading < 0 || !section.is_round || is_linear[static_cast<std::size_t>(section.leading)]) continue;
        const auto at = section.wing->edges(surface, start_, section.side, section.place, false, &section.triangles);
        if (!at) throw no_section(*section.wing, section.place);
        found.segment<2>(2 * section.leading) << at->leading.x.value - section.leading_at[0],
            at->leading.z.value - section.leading_at[1];
    }
    return found;
}

std::shared_ptr<const KeptSections::Tangent> KeptSections::tangent_at(const Points& vertices, bool is_end) const {
    const std::scoped_lock lock(guard_);
    if (at_start_ && at_start_->surface == vertices) return at_start_;
    if (latest_ && latest_->surface == vertices) return latest_;
    const TriMesh surface = with_vertices(start_, vertices);
    EdgeRows rows;
    const bool is_first = !at_start_;
    for (const Section& section : sections_) {
        if (!is_first) rows.copy(section.trailing, at_start_->edges);
        if (!is_first && !section.is_round) {
            rows.copy(section.leading, at_start_->edges);
            continue;
        }
        if (!is_first && section.leading < 0) continue;
        const auto at = section.wing->edges(surface, start_, section.side, section.place, true, &section.triangles);
        if (!at) throw no_section(*section.wing, section.place);
        const Eigen::Vector2d off = Eigen::Vector2d(at->leading.x.value, at->leading.z.value) - section.leading_at;
        const bool jumps = !is_first && is_end && off.norm() > told_apart * section.chord;  // as `kept` found it
        if (jumps) rows.copy(section.leading, at_start_->edges);
        const VectorXd* freedom = section.is_round ? &freedom_ : nullptr;
        if (!jumps) rows.add(section.leading, at->leading, freedom);
        if (is_first) rows.add(section.trailing, at->trailing, freedom);
    }
    auto tangent = std::make_shared<Tangent>();
    tangent->surface = vertices;
    tangent->edges.resize(2 * num_knots_, 3 * num_vertices());
    tangent->edges.setFromTriplets(rows.entries.begin(), rows.entries.end());
    tangent->by_knots.compute(Eigen::MatrixXd(tangent->edges * by_knots_));
    if (is_end) latest_ = tangent;
    return tangent;
}

Points KeptSections::kept(const Points& motion) const {
    Points free = in_planes(motion), moved = free;
    if (free.isZero(0)) return moved;
    if (num_knots_ == 0) return held(free);
    const VectorXd chord = chords_of(sections_, num_knots_);
    std::shared_ptr<const Tangent> tangent = at_start_;
    std::vector<char> is_linear(static_cast<std::size_t>(num_knots_), 0);
    double before = std::numeric_limits<double>::infinity();
    TriMesh surface = start_;
    for (int k = 0; k < max_iterations; ++k) {
        moved = held(free);
        surface.vertices = start_.vertices + moved;
        // Rounded as the surface is, where nothing is held: the same bits as ever.
        const VectorXd left = off(surface, holds_noses_ ? free : Points(surface.vertices - start_.vertices), is_linear);
        const double size = left.cwiseQuotient(chord).cwiseAbs().maxCoeff();
        if (size < edge_tolerance || (size < near_enough && size > slow * before)) return moved;
        if (k >= max_iterations / 2) mark_left(left, chord, is_linear);
        if (k > 1 && size > slow * before) tangent = tangent_at(surface.vertices, false);
        before = size;
        const VectorXd step = by_knots_ * tangent->by_knots.solve(left);
        if (!step.allFinite()) break;
        free -= points(step);
    }
    throw SolverError(text("wing '", sections_.front().wing->declaration().name,
                           "': its edges cannot be brought back to where they were (", before,
                           " of the chord is left): sections are deformed too far"));
}

Points KeptSections::rate(const Points* surface, const Points& motion) const {
    const Points moved = in_planes(motion);
    if (num_knots_ == 0) return held(moved);
    const auto tangent = surface ? tangent_at(*surface, true) : at_start_;
    return held(moved - points(by_knots_ * tangent->by_knots.solve(tangent->edges * flat(moved))));
}

Points KeptSections::pulled_back(const Points* surface, const Points& dJ_dv) const {
    if (num_knots_ == 0) return in_planes(held(dJ_dv));
    const auto tangent = surface ? tangent_at(*surface, true) : at_start_;
    const Points by_free = held(dJ_dv);
    const VectorXd by_knot = by_knots_.transpose() * flat(by_free);
    const VectorXd by_edge = tangent->by_knots.transpose().solve(by_knot);
    return in_planes(by_free - points(tangent->edges.transpose() * by_edge));
}

namespace {

/// Of the plane of a triangle: gradients of the functions that are 1 at a corner and 0 at the others, one a column,
/// and its unit normal.
struct Hats {
    Eigen::Matrix3d gradient;
    Vector3d normal;
};

Hats hats(const TriMesh& mesh, int t) {
    Eigen::Matrix3d corner;
    for (int k = 0; k < 3; ++k) corner.col(k) = mesh.vertices.row(mesh.triangles(t, k)).transpose();
    const Vector3d area = (corner.col(1) - corner.col(0)).cross(corner.col(2) - corner.col(0));
    Hats of{Eigen::Matrix3d::Zero(), Vector3d::Zero()};
    if (!(area.squaredNorm() > 0)) return of;
    of.normal = area.normalized();
    for (int k = 0; k < 3; ++k)
        of.gradient.col(k) = area.cross(corner.col((k + 2) % 3) - corner.col((k + 1) % 3)) / area.squaredNorm();
    return of;
}

}  // namespace

/// How B a changes along a normal of the surface, at a vertex: w -> alpha (1 - zeta) + beta zeta is linear in the
/// plane.
Vector3d KeptSections::across_rate(int v, const Vector3d& normal, const VectorXd& knots) const {
    const Share& share = shares_[static_cast<std::size_t>(v)];
    const Complex zeta = Complex(share.downstream.dot(normal), share.up.dot(normal)) / share.chord;
    Complex rate = 0;
    for (const Term& term : share.terms)
        rate += zeta * term.slope * Complex(knots[2 * term.knot], knots[2 * term.knot + 1]);
    return rate.real() * share.downstream + rate.imag() * share.up;
}

void KeptSections::change_maps(const Points& motion, std::vector<Eigen::Matrix3d>& maps) const {
    const VectorXd knots =
        num_knots_ == 0 ? VectorXd(0) : VectorXd(at_start_->by_knots.solve(at_start_->edges * flat(in_planes(motion))));
    const Points correction = points(by_knots_ * knots), free = in_planes(motion) - correction;
    for (int t = 0; t < start_.num_triangles(); ++t) {
        const Hats of = hats(start_, t);
        Eigen::Matrix3d slope = maps[static_cast<std::size_t>(t)] - Eigen::Matrix3d::Identity(), taken;
        taken.setZero();
        for (int k = 0; k < 3; ++k) {
            const int v = start_.triangles(t, k);
            const Vector3d across = across_.row(v);
            taken += across * (across.transpose() * slope) / 3;
            taken += correction.row(v).transpose() * of.gradient.col(k).transpose();
            taken += across_rate(v, of.normal, knots) * of.normal.transpose() / 3;
        }
        maps[static_cast<std::size_t>(t)] -= taken;
        if (!holds_noses_) continue;
        const double mean = mean_freedom(t);
        Eigen::Matrix3d& map = maps[static_cast<std::size_t>(t)];
        map = Eigen::Matrix3d::Identity() + mean * (map - Eigen::Matrix3d::Identity());
        for (int k = 0; k < 3; ++k) {
            const int v = start_.triangles(t, k);
            map += (freedom_[v] - mean) * free.row(v).transpose() * of.gradient.col(k).transpose();
        }
    }
}

double KeptSections::mean_freedom(int t) const {
    double sum = 0;
    for (const int v : start_.triangles.row(t)) sum += freedom_[v];
    return sum / 3;
}

Eigen::Matrix3d KeptSections::pull_map(int t, const Eigen::Matrix3d& dJ_dmap, Points& dJ_dd) const {
    const Hats of = hats(start_, t);
    const double mean = holds_noses_ ? mean_freedom(t) : 1;
    const Eigen::Matrix3d dJ_dF = mean * dJ_dmap;
    Points by_free = Points::Zero(num_vertices(), 3);
    Eigen::Matrix3d by_map = dJ_dF;
    VectorXd by_knot = VectorXd::Zero(2 * num_knots_);
    for (int k = 0; k < 3; ++k) {
        const int v = start_.triangles(t, k);
        const Share& share = shares_[static_cast<std::size_t>(v)];
        by_free.row(v) += (freedom_[v] - mean) * dJ_dmap * of.gradient.col(k);
        const Vector3d across = across_.row(v),
                       by_correction = -dJ_dF * of.gradient.col(k) - by_free.row(v).transpose(),
                       by_rate = -dJ_dF * of.normal / 3;
        by_map -= across * (across.transpose() * dJ_dF) / 3;
        const Complex zeta = Complex(share.downstream.dot(of.normal), share.up.dot(of.normal)) / share.chord;
        const auto in_plane = [&](const Vector3d& f) { return Complex(share.downstream.dot(f), share.up.dot(f)); };
        for (const Term& term : share.terms) {
            const Complex by =
                std::conj(term.weight) * in_plane(by_correction) + std::conj(zeta * term.slope) * in_plane(by_rate);
            by_knot.segment<2>(2 * term.knot) += Eigen::Vector2d(by.real(), by.imag());
        }
    }
    if (num_knots_ > 0) {
        const VectorXd by_edge = at_start_->by_knots.transpose().solve(by_knot);
        by_free += points(at_start_->edges.transpose() * by_edge);
    }
    dJ_dd = in_planes(by_free);
    return by_map;
}

}  // namespace strake
