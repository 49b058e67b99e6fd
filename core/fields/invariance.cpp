#include "core/fields/invariance.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/point_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

namespace strake {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double same_length = 1e-9;  ///< of a direction from one

std::string place(const Vector3d& x) { return text("(", x[0], ", ", x[1], ", ", x[2], ")"); }

std::string axis_words(const Vector3d& axis) {
    for (int k = 0; k < 3; ++k)
        if (std::abs(axis[k]) > 1 - same_length) return {"xyz"[k]};
    return place(axis);
}

/// Numbers of the classes of points that are at most `tolerance` from the first one of the class, in the order of the
/// vertices.
std::vector<int> classes_of(const Points& at, double tolerance) {
    const PointTree tree(at);
    std::vector<int> of(static_cast<std::size_t>(at.rows()), -1), near;
    int count = 0;
    for (int v = 0; v < at.rows(); ++v) {
        if (of[static_cast<std::size_t>(v)] >= 0) continue;
        tree.within(at.row(v), tolerance, near);
        for (const int w : near)
            if (of[static_cast<std::size_t>(w)] < 0) of[static_cast<std::size_t>(w)] = count;
        of[static_cast<std::size_t>(v)] = count++;
    }
    return of;
}

/// Distance of a point from the nearest one of another class.
double nearest_other(const PointTree& tree, const Points& at, const std::vector<int>& class_of, int v, double limit) {
    std::vector<int> near;
    double least = std::numeric_limits<double>::infinity();
    for (double radius = 4 * limit; least > radius && radius < 1e9 * limit; radius *= 4) {
        tree.within(at.row(v), radius, near);
        for (const int w : near)
            if (class_of[static_cast<std::size_t>(w)] != class_of[static_cast<std::size_t>(v)])
                least = std::min(least, (at.row(w) - at.row(v)).norm());
    }
    return least;
}

Vector3d centroid(const TriMesh& mesh, int t) {
    Vector3d sum = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) sum += mesh.vertices.row(mesh.triangles(t, k)).transpose() / 3;
    return sum;
}

/// Smallest height of a triangle, zero where it has no area.
double smallest_height(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    return longest > 0 ? (b - a).cross(c - a).norm() / longest : 0;
}

void check(const ShapeKind& kind, double tolerance) {
    if (!(std::abs(kind.axis.norm() - 1) < same_length) || !kind.through.allFinite())
        throw InvalidInput(text("invariance: the axis has length ", kind.axis.norm(), ", not 1"));
    if (kind.type == ShapeKind::Type::cyclic && kind.count < 2)
        throw InvalidInput(text("invariance: cyclic = ", kind.count, " must be >= 2"));
    if (!(tolerance > 0)) throw InvalidInput(text("invariance: tolerance = ", tolerance, " must be > 0"));
}

std::string off_by(double deviation, double limit) {
    return text(" by ", deviation, " (limit ", limit, ", a millionth of the diagonal)");
}

}  // namespace

std::string to_string(const ShapeKind& kind) {
    switch (kind.type) {
        case ShapeKind::Type::extruded:
            return "extruded along " + axis_words(kind.axis);
        case ShapeKind::Type::revolved:
            return text("revolved about ", axis_words(kind.axis), " through ", place(kind.through));
        case ShapeKind::Type::cyclic:
            return text("cyclic in ", kind.count, " about ", axis_words(kind.axis), " through ", place(kind.through));
    }
    return "";
}

Invariance::Invariance(const TriMesh& rest, const ShapeKind& kind, double tolerance,
                       const std::optional<SymmetryPlane>& cut)
    : kind_(kind),
      weight_(VectorXd::Ones(rest.num_vertices())),
      is_on_axis_(static_cast<std::size_t>(rest.num_vertices()), 0) {
    check(kind, tolerance);
    const double limit = tolerance * box_diagonal(rest);
    for (int v = 0; cut && v < rest.num_vertices(); ++v)
        if (std::abs(cut->normal.dot(rest.vertices.row(v)) - cut->offset) <= limit) weight_[v] = 0.5;
    if (kind.type == ShapeKind::Type::extruded) classify_columns(rest, limit);
    if (kind.type == ShapeKind::Type::revolved) classify_rings(rest, limit, cut);
    if (kind.type == ShapeKind::Type::cyclic) classify_sectors(rest, limit);
    collect();
}

/// Columns of vertices that differ along the axis alone. A triangle lies across the axis (an end) or between two
/// columns (a side); between three, a side would not stay flat along the axis.
void Invariance::classify_columns(const TriMesh& rest, double limit) {
    const VectorXd along = rest.vertices * kind_.axis;
    const Points section = rest.vertices - along * kind_.axis.transpose();
    class_of_ = classes_of(section, limit);
    double most = limit;
    int worst = -1, beside = -1;
    for (int t = 0; t < rest.num_triangles(); ++t) {
        const int a = rest.triangles(t, 0), b = rest.triangles(t, 1), c = rest.triangles(t, 2);
        const double depth = std::max({along[a], along[b], along[c]}) - std::min({along[a], along[b], along[c]});
        if (depth <= limit) continue;
        const double width = smallest_height(section.row(a), section.row(b), section.row(c));
        if (std::min(depth, width) > most) most = std::min(depth, width), worst = t;
        const bool is_between = class_of(a) != class_of(b) && class_of(b) != class_of(c) && class_of(a) != class_of(c);
        if (is_between && beside < 0) beside = t;
    }
    if (worst >= 0)
        throw InvalidInput(text("invariance: the surface is not ", to_string(kind_), ": triangle ", worst, " at ",
                                place(centroid(rest, worst)), " lies neither across the axis nor along it; it is off",
                                off_by(most, limit)));
    if (beside >= 0)
        throw InvalidInput(text("invariance: triangle ", beside, " at ", place(centroid(rest, beside)),
                                " touches three columns of vertices along ", axis_words(kind_.axis),
                                ": it would bend; mesh the sides in straight columns"));
}

/// Rings of vertices at the same place along the axis and the same distance from it.
void Invariance::classify_rings(const TriMesh& rest, double limit, const std::optional<SymmetryPlane>& cut) {
    const int n = rest.num_vertices();
    Points at = Points::Zero(n, 3);
    frame_.assign(static_cast<std::size_t>(n), Matrix3d::Identity());
    for (int v = 0; v < n; ++v) {
        const Vector3d arm = Vector3d(rest.vertices.row(v)) - kind_.through;
        at(v, 0) = arm.dot(kind_.axis);
        Vector3d out = arm - at(v, 0) * kind_.axis;
        at(v, 1) = out.norm();
        is_on_axis_[static_cast<std::size_t>(v)] = at(v, 1) <= limit;
        if (cut && std::abs(cut->normal.dot(rest.vertices.row(v)) - cut->offset) <= limit)
            out -= out.dot(cut->normal) * cut->normal;
        if (!is_on_axis_[static_cast<std::size_t>(v)]) out.normalize();
        frame_[static_cast<std::size_t>(v)] << kind_.axis, out, kind_.axis.cross(out);
    }
    class_of_ = classes_of(at, limit);
    collect();
    const PointTree tree(at);
    double most = -1;
    int worst = -1;
    for (int c = 0; c < num_classes(); ++c) {
        const int v = member_[static_cast<std::size_t>(first_[static_cast<std::size_t>(c)])];
        if (is_on_axis_[static_cast<std::size_t>(v)] || goes_around(c, cut.has_value())) continue;
        const double least = nearest_other(tree, at, class_of_, v, limit);
        if (least > most) most = least, worst = v;
    }
    if (worst >= 0)
        throw InvalidInput(text("invariance: the surface is not ", to_string(kind_), ": vertex ", worst, " at ",
                                place(rest.vertices.row(worst)),
                                " lies on no ring of vertices around the axis; it misses the nearest other one",
                                off_by(most, limit)));
}

/// The class is a ring, or half of one: no gap is wider than between the corners of a triangle.
bool Invariance::goes_around(int c, bool is_half) const {
    const double widest = (is_half ? 1.0 : 2.0 / 3) * 2 * std::numbers::pi + 1e-6;
    const Vector3d any = kind_.axis.unitOrthogonal(), other = kind_.axis.cross(any);
    std::vector<double> angle;
    for (int i = first_[static_cast<std::size_t>(c)]; i < first_[static_cast<std::size_t>(c) + 1]; ++i) {
        const Vector3d out = frame_[static_cast<std::size_t>(member_[static_cast<std::size_t>(i)])].col(1);
        angle.push_back(std::atan2(out.dot(other), out.dot(any)));
    }
    std::sort(angle.begin(), angle.end());
    double gap = angle.front() + 2 * std::numbers::pi - angle.back();
    for (std::size_t i = 1; i < angle.size(); ++i) gap = std::max(gap, angle[i] - angle[i - 1]);
    return angle.size() >= (is_half ? 2 : 3) && gap <= widest;
}

/// Images under rotations by 1 / count of a turn, vertices and triangles.
void Invariance::classify_sectors(const TriMesh& rest, double limit) {
    const int n = rest.num_vertices();
    const PointTree tree(rest.vertices);
    const Matrix3d turn = Eigen::AngleAxisd(2 * std::numbers::pi / kind_.count, kind_.axis).toRotationMatrix();
    std::vector<int> image(static_cast<std::size_t>(n));
    double most = limit;
    int worst = -1;
    for (int v = 0; v < n; ++v) {
        const Vector3d arm = Vector3d(rest.vertices.row(v)) - kind_.through;
        is_on_axis_[static_cast<std::size_t>(v)] = arm.cross(kind_.axis).norm() <= limit;
        const auto [w, distance] = tree.nearest(kind_.through + turn * arm);
        image[static_cast<std::size_t>(v)] = w;
        if (distance > most) most = distance, worst = v;
    }
    if (worst >= 0)
        throw InvalidInput(text("invariance: the surface is not ", to_string(kind_), ": the image of vertex ", worst,
                                " at ", place(rest.vertices.row(worst)), " misses the nearest vertex",
                                off_by(most, limit)));
    class_of_.assign(static_cast<std::size_t>(n), -1);
    frame_.assign(static_cast<std::size_t>(n), Matrix3d::Identity());
    int count = 0;
    for (int v = 0; v < n; ++v) {
        if (class_of(v) >= 0) continue;
        int w = v;
        for (int k = 0; k < kind_.count && class_of(w) < 0; ++k, w = image[static_cast<std::size_t>(w)]) {
            class_of_[static_cast<std::size_t>(w)] = count;
            frame_[static_cast<std::size_t>(w)] =
                Eigen::AngleAxisd(2 * std::numbers::pi * k / kind_.count, kind_.axis).toRotationMatrix();
        }
        if (w != v)
            throw InvalidInput(text("invariance: the surface is not ", to_string(kind_), ": the images of vertex ", v,
                                    " at ", place(rest.vertices.row(v)), " do not lead back to it; two vertices lie ",
                                    "within ", limit, " of each other"));
        ++count;
    }
    std::set<std::array<int, 3>> known;
    const auto sorted = [](std::array<int, 3> t) {
        std::sort(t.begin(), t.end());
        return t;
    };
    for (int t = 0; t < rest.num_triangles(); ++t)
        known.insert(sorted({rest.triangles(t, 0), rest.triangles(t, 1), rest.triangles(t, 2)}));
    for (int t = 0; t < rest.num_triangles(); ++t)
        if (!known.contains(sorted({image[static_cast<std::size_t>(rest.triangles(t, 0))],
                                    image[static_cast<std::size_t>(rest.triangles(t, 1))],
                                    image[static_cast<std::size_t>(rest.triangles(t, 2))]})))
            throw InvalidInput(text("invariance: the surface is not ", to_string(kind_), ": the image of triangle ", t,
                                    " at ", place(centroid(rest, t)),
                                    " is no triangle, though its corners are vertices; mesh one sector and copy it"));
}

void Invariance::collect() {
    const int count = class_of_.empty() ? 0 : *std::max_element(class_of_.begin(), class_of_.end()) + 1;
    first_.assign(static_cast<std::size_t>(count) + 1, 0);
    for (const int c : class_of_) ++first_[static_cast<std::size_t>(c) + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    member_.resize(class_of_.size());
    std::vector<int> next(first_.begin(), first_.end() - 1);
    for (std::size_t v = 0; v < class_of_.size(); ++v)
        member_[static_cast<std::size_t>(next[static_cast<std::size_t>(class_of_[v])]++)] = static_cast<int>(v);
}

/// In the coordinates of the class.
Vector3d Invariance::allowed(int v, Vector3d motion) const {
    const bool is_on_axis = is_on_axis_[static_cast<std::size_t>(v)] != 0;
    switch (kind_.type) {
        case ShapeKind::Type::extruded:
            return motion - motion.dot(kind_.axis) * kind_.axis;
        case ShapeKind::Type::revolved:  // along the axis, outward, around
            return {motion[0], is_on_axis ? 0 : motion[1], 0};
        case ShapeKind::Type::cyclic:
            return is_on_axis ? Vector3d(motion.dot(kind_.axis) * kind_.axis) : motion;
    }
    return motion;
}

Points Invariance::averaged(const Points& of, bool is_transposed) const {
    if (of.rows() != num_vertices())
        throw InvalidInput(text("invariance: ", of.rows(), " rows for ", num_vertices(), " vertices"));
    Points result(of.rows(), 3);
    for (int c = 0; c < num_classes(); ++c) {
        const int first = first_[static_cast<std::size_t>(c)], end = first_[static_cast<std::size_t>(c) + 1];
        Vector3d sum = Vector3d::Zero();
        double weight = 0;
        for (int i = first; i < end; ++i) {
            const int v = member_[static_cast<std::size_t>(i)];
            const Vector3d own = (is_transposed ? 1 : weight_[v]) * of.row(v);
            sum += frame_.empty() ? own : frame_[static_cast<std::size_t>(v)].transpose() * own;
            weight += weight_[v];
        }
        const Vector3d mean = allowed(member_[static_cast<std::size_t>(first)], sum / weight);
        for (int i = first; i < end; ++i) {
            const int v = member_[static_cast<std::size_t>(i)];
            const Vector3d own = (is_transposed ? weight_[v] : 1) * mean;
            result.row(v) = frame_.empty() ? own : Vector3d(frame_[static_cast<std::size_t>(v)] * own);
        }
    }
    return result;
}

Points Invariance::projected(const Points& motion) const { return averaged(motion, false); }

Points Invariance::pulled_back(const Points& forces) const { return averaged(forces, true); }

void Invariance::check_held(const TriMesh& rest, const std::vector<int>& triangles) const {
    std::vector<char> is_held(static_cast<std::size_t>(num_vertices()), 0);
    for (const int t : triangles)
        for (int k = 0; k < 3; ++k) is_held[static_cast<std::size_t>(rest.triangles(t, k))] = 1;
    for (int c = 0; c < num_classes(); ++c) {
        int held = -1, free = -1;
        for (int i = first_[static_cast<std::size_t>(c)]; i < first_[static_cast<std::size_t>(c) + 1]; ++i) {
            const int v = member_[static_cast<std::size_t>(i)];
            (is_held[static_cast<std::size_t>(v)] ? held : free) = v;
        }
        if (held < 0 || free < 0) continue;
        const char* remedy = kind_.type == ShapeKind::Type::extruded   ? "hold whole columns"
                             : kind_.type == ShapeKind::Type::revolved ? "hold whole rings"
                                                                       : "hold the same in every sector";
        throw InvalidInput(text("invariance: what is held must be ", to_string(kind_), ", too: vertex ", held, " at ",
                                place(rest.vertices.row(held)), " is held, vertex ", free, " at ",
                                place(rest.vertices.row(free)), ", which moves with it, is not; ", remedy));
    }
}

Points motion_of_columns(const Points& points, const Vector3d& axis, double tolerance, const Points& motion) {
    if (points.rows() != motion.rows())
        throw InvalidInput(text("columns: ", motion.rows(), " motions for ", points.rows(), " points"));
    const std::vector<int> of = classes_of(points - points * axis * axis.transpose(), tolerance);
    const int count = of.empty() ? 0 : *std::max_element(of.begin(), of.end()) + 1;
    Points mean = Points::Zero(count, 3);
    VectorXd size = VectorXd::Zero(count);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        mean.row(of[static_cast<std::size_t>(v)]) += motion.row(v);
        size[of[static_cast<std::size_t>(v)]] += 1;
    }
    mean = size.cwiseInverse().asDiagonal() * mean;
    mean -= (mean * axis) * axis.transpose().eval();
    Points kept(points.rows(), 3);
    for (Eigen::Index v = 0; v < points.rows(); ++v) kept.row(v) = mean.row(of[static_cast<std::size_t>(v)]);
    return kept;
}

double Invariance::deviation(const Points& motion) const {
    return motion.rows() == 0 ? 0 : (motion - projected(motion)).rowwise().norm().maxCoeff();
}

}  // namespace strake
