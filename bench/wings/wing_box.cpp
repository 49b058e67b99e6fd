#include "bench/wings/wing_box.hpp"

#include "core/error.hpp"
#include "core/mesh/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace strake::evidence {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int num_sections = 40;
constexpr double margin = 0.05;  ///< of the box above and below, of the thickness

/// A section of the start: downstream and up of its edges, half of the box's height.
struct Frame {
    double station = 0;
    Vector2d leading, trailing;
    double half_height = 0;
};

std::vector<Frame> frames(const TriMesh& surface, const Wing& wing) {
    const Vector3d &downstream = wing.declaration().downstream, &up = wing.declaration().up;
    const auto flat = [&](const Vector3d& p) { return Vector2d(downstream.dot(p), up.dot(p)); };
    std::vector<Frame> all;
    for (int i = 0; i <= num_sections; ++i) {
        const double station = double(i) / num_sections;
        const StationFacts at = wing.station(surface, station);
        all.push_back({wing.place(0, station), flat(at.leading_edge), flat(at.trailing_edge),
                       0.5 * (1 + margin) * at.thickness_to_chord.value * at.chord.value});
    }
    return all;
}

Frame frame_at(const std::vector<Frame>& all, double place) {
    std::size_t k = 1;
    while (k + 1 < all.size() && all[k].station < place) ++k;
    const Frame &a = all[k - 1], &b = all[k];
    const double t = std::clamp((place - a.station) / (b.station - a.station), 0.0, 1.0);
    return {place, a.leading + t * (b.leading - a.leading), a.trailing + t * (b.trailing - a.trailing),
            a.half_height + t * (b.half_height - a.half_height)};
}

/// What moves: weights of the points (one column each), of the planes along the span, and the axis of twist.
struct Moving {
    std::vector<int> vertex;
    MatrixXd points, planes;
    Eigen::MatrixX2d axis;  ///< downstream, up
};

Moving moving(const TriMesh& surface, const Wing& wing, const WingBox& box) {
    const Vector3d &downstream = wing.declaration().downstream, &up = wing.declaration().up;
    const std::vector<Frame> all = frames(surface, wing);
    const std::vector<Wing::Place> places = wing.places(surface);
    std::vector<char> of_wing(static_cast<std::size_t>(surface.num_vertices()), 0);
    for (int side = 0; side < wing.num_sides(); ++side)
        for (const int v : wing.vertices(side)) of_wing[static_cast<std::size_t>(v)] = 1;
    Moving result;
    for (int v = 0; v < surface.num_vertices(); ++v)
        if (of_wing[static_cast<std::size_t>(v)]) result.vertex.push_back(v);
    const auto rows = static_cast<Eigen::Index>(result.vertex.size());
    const auto [nx, ny, nz] = box.points;
    const int first = box.root_held ? 1 : 0;
    result.points.resize(rows, nx * (ny - first) * nz);
    result.planes.resize(rows, box.twist > 0 ? ny - 1 : 0);
    result.axis.resize(rows, 2);
    for (Eigen::Index r = 0; r < rows; ++r) {
        const int v = result.vertex[static_cast<std::size_t>(r)];
        const Wing::Place& at = places[static_cast<std::size_t>(v)];
        const Frame frame = frame_at(all, at.span);
        const Vector3d x = surface.vertices.row(v);
        const Vector2d chord = frame.trailing - frame.leading,
                       off = Vector2d(downstream.dot(x), up.dot(x)) - frame.leading;
        const double s = std::clamp(at.span, 0.0, 1.0),
                     along = std::clamp(off.dot(chord) / chord.squaredNorm(), 0.0, 1.0);
        const double height = (chord[0] * off[1] - chord[1] * off[0]) / chord.norm();
        const double above = std::clamp(0.5 + 0.5 * height / std::max(frame.half_height, 1e-12), 0.0, 1.0);
        result.axis.row(r) = (frame.leading + 0.25 * chord).transpose();
        Eigen::Index column = 0;
        for (int j = 0; j < ny; ++j) {
            const double by_span = b_spline(ny, j, s);
            if (j > 0 && result.planes.cols() > 0) result.planes(r, j - 1) = by_span;
            for (int i = 0; j >= first && i < nx; ++i)
                for (int k = 0; k < nz; ++k)
                    result.points(r, column++) = by_span * b_spline(nx, i, along) * b_spline(nz, k, above);
        }
    }
    return result;
}

/// Variables: points up, points downstream (if they move so), twists.
struct Box {
    Moving moving;
    Points rest;
    Vector3d downstream, up;
    Eigen::Index num_points = 0, num_downstream = 0;
    double reach = 0, twist = 0;

    Eigen::Index size() const { return num_points + num_downstream + moving.planes.cols(); }
    /// Off the axis after the points have moved, and the angle there.
    struct Section {
        Eigen::MatrixX2d off;
        VectorXd angle;
    };
    Section section(const VectorXd& x) const {
        Section at{Eigen::MatrixX2d(moving.axis.rows(), 2), twist * (moving.planes * x.tail(moving.planes.cols()))};
        const VectorXd up_by = reach * (moving.points * x.head(num_points));
        VectorXd aft_by = VectorXd::Zero(up_by.size());
        if (num_downstream > 0) aft_by = reach * (moving.points * x.segment(num_points, num_downstream));
        for (Eigen::Index r = 0; r < at.off.rows(); ++r) {
            const Vector3d p = rest.row(moving.vertex[static_cast<std::size_t>(r)]);
            at.off.row(r) << downstream.dot(p) + aft_by[r] - moving.axis(r, 0),
                up.dot(p) + up_by[r] - moving.axis(r, 1);
        }
        return at;
    }
    Points vertices(const VectorXd& x) const {
        const Section at = section(x);
        Points v = rest;
        for (Eigen::Index r = 0; r < at.off.rows(); ++r) {
            const double c = std::cos(at.angle[r]), s = std::sin(at.angle[r]);
            const int k = moving.vertex[static_cast<std::size_t>(r)];
            const Vector3d p = rest.row(k);
            const double aft = moving.axis(r, 0) + c * at.off(r, 0) + s * at.off(r, 1);
            const double high = moving.axis(r, 1) - s * at.off(r, 0) + c * at.off(r, 1);
            v.row(k) += ((aft - downstream.dot(p)) * downstream + (high - up.dot(p)) * up).transpose();
        }
        return v;
    }
    VectorXd gradient(const VectorXd& x, const Points& dJ_dv) const {
        const Section at = section(x);
        VectorXd by_up(at.off.rows()), by_aft(at.off.rows()), by_angle(at.off.rows());
        for (Eigen::Index r = 0; r < at.off.rows(); ++r) {
            const double c = std::cos(at.angle[r]), s = std::sin(at.angle[r]);
            const Vector3d g = dJ_dv.row(moving.vertex[static_cast<std::size_t>(r)]);
            const double aft = downstream.dot(g), high = up.dot(g);
            by_up[r] = s * aft + c * high;
            by_aft[r] = c * aft - s * high;
            by_angle[r] = aft * (-s * at.off(r, 0) + c * at.off(r, 1)) - high * (c * at.off(r, 0) + s * at.off(r, 1));
        }
        VectorXd g(size());
        g.head(num_points) = reach * (moving.points.transpose() * by_up);
        if (num_downstream > 0) g.segment(num_points, num_downstream) = reach * (moving.points.transpose() * by_aft);
        g.tail(moving.planes.cols()) = twist * (moving.planes.transpose() * by_angle);
        return g;
    }
};

/// Root mean square displacement of the surface by the variables at rest, as a quadratic form.
MatrixXd metric_at_rest(const TriMesh& surface, const Box& box) {
    const VectorXd area = vertex_areas(surface);
    const auto rows = box.moving.points.rows();
    MatrixXd aft = MatrixXd::Zero(rows, box.size()), high = aft;
    high.leftCols(box.num_points) = box.reach * box.moving.points;
    if (box.num_downstream > 0) aft.middleCols(box.num_points, box.num_downstream) = box.reach * box.moving.points;
    const Box::Section rest = box.section(VectorXd::Zero(box.size()));
    const Eigen::Index n = box.moving.planes.cols();
    aft.rightCols(n) = box.twist * (rest.off.col(1).asDiagonal() * box.moving.planes);
    high.rightCols(n) = -box.twist * (rest.off.col(0).asDiagonal() * box.moving.planes);
    VectorXd share(rows);
    for (Eigen::Index r = 0; r < rows; ++r)
        share[r] = area[box.moving.vertex[static_cast<std::size_t>(r)]] / area.sum();
    const double unit = 2 / box.reach;
    MatrixXd square =
        unit * unit * (aft.transpose() * share.asDiagonal() * aft + high.transpose() * share.asDiagonal() * high);
    square.diagonal() *= 1 + 1e-9;
    return square;
}

}  // namespace

ComparedMotion wing_box(const TriMesh& surface, const Wing& wing, const WingBox& shape) {
    if (wing.has_winglet()) throw InvalidInput("a wing with a winglet has no box here");
    const auto box = std::make_shared<Box>();
    box->rest = surface.vertices;
    box->moving = moving(surface, wing, shape);
    box->downstream = wing.declaration().downstream;
    box->up = wing.declaration().up;
    box->num_points = box->moving.points.cols();
    box->num_downstream = shape.moves_downstream ? box->num_points : 0;
    box->reach = shape.reach * wing.facts(surface).mean_chord.value;
    box->twist = shape.twist;
    const MatrixXd square = metric_at_rest(surface, *box);
    ComparedMotion motion;
    motion.name = text("box_", shape.points[0], "x", shape.points[1], "x", shape.points[2]);
    motion.lower = VectorXd::Constant(box->size(), -1);
    motion.upper = VectorXd::Constant(box->size(), 1);
    motion.weight = square.diagonal().cwiseSqrt();
    motion.metric = motion.weight.cwiseInverse().asDiagonal() * square * motion.weight.cwiseInverse().asDiagonal();
    motion.vertices = [box](const VectorXd& x) { return box->vertices(x); };
    motion.gradient = [box](const VectorXd& x, const Points& dJ_dv) { return box->gradient(x, dJ_dv); };
    return motion;
}

}  // namespace strake::evidence
