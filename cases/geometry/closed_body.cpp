#include "cases/geometry/closed_body.hpp"

#include "cases/geometry/rows.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake::example {
namespace {

constexpr double pi = std::numbers::pi;

/// One row from the top line to the bottom line; its ends lie on y = 0 exactly.
std::vector<int> add_row(SurfaceBuilder& builder, const BodySkin& skin, double along, double edge_length) {
    const Curve row = [&](double around) {
        Eigen::Vector3d p = skin(along, around);
        if (around == 0 || around == 1) p.y() = 0;
        return p;
    };
    const ArcTable table = arc_table(row, 200);
    const int pieces = std::max(2, static_cast<int>(std::lround(table.total() / edge_length)));
    std::vector<int> points;
    for (int k = 0; k <= pieces; ++k)
        points.push_back(builder.add(row(k == 0 ? 0 : k == pieces ? 1 : table.parameter(table.total() * k / pieces))));
    return points;
}

TriMesh body_of_edge_length(const BodySkin& skin, double edge_length) {
    // Rows a mean of three meridians apart as rows of equilateral triangles are.
    const auto meridian = [&](double around) {
        return arc_table([&](double along) { return skin(along, around); }, 400);
    };
    const ArcTable length = mean_of(meridian(0.5), mean_of(meridian(0.02), meridian(0.98)));
    const int rows = std::max(4, static_cast<int>(std::lround(length.total() / (0.866 * edge_length))));
    SurfaceBuilder builder{.mirror_axis = 1};
    const auto pole = [&](double along) {
        Eigen::Vector3d p = skin(along, 0);
        p.y() = 0;
        return builder.add(p);
    };
    std::vector<int> last{pole(0)};
    for (int r = 1; r <= rows; ++r) {
        std::vector<int> next = r < rows
                                    ? add_row(builder, skin, length.parameter(length.total() * r / rows), edge_length)
                                    : std::vector<int>{pole(1)};
        builder.stitch(last, next, true);
        last = std::move(next);
    }
    builder.mirror();
    return builder.mesh();
}

/// Meridian of a capsule of unit radius and the given length by its share of arc length: (x, r).
Eigen::Vector2d capsule_meridian(double length, double share) {
    const double quarter = pi / 2, straight = std::max(0.0, length - 2), total = 2 * quarter + straight;
    const double s = share * total;
    if (s <= quarter) return {1 - std::cos(s), std::sin(s)};
    if (s < quarter + straight) return {1 + s - quarter, 1};
    return {length - 1 + std::cos(total - s), std::sin(total - s)};
}

/// 1 on the axis of the nacelle, falling to 0 with slope 0 at its outline: s and q in [-1, 1].
double nacelle(double s, double q) {
    if (std::abs(s) >= 1 || std::abs(q) >= 1) return 0;
    const double lengthwise = 1 - s * s * s * s, across = 1 - q * q;
    return lengthwise * lengthwise * across * across;
}

}  // namespace

TriMesh closed_body(int triangles, const BodySkin& skin) {
    const double size = (skin(1, 0) - skin(0, 0)).norm();
    return with_triangle_count(triangles, 200, size * std::sqrt(4.0 / triangles),
                               [&](double edge_length) { return body_of_edge_length(skin, edge_length); });
}

TriMesh sphere(int triangles, double radius) {
    return closed_body(triangles, [radius](double along, double around) {
        const double a = pi * along, b = pi * around;
        return Eigen::Vector3d(radius *
                               Eigen::Vector3d(-std::cos(a), std::sin(a) * std::sin(b), std::sin(a) * std::cos(b)));
    });
}

TriMesh superellipsoid(int triangles, const SuperellipsoidShape& shape) {
    if (!(shape.exponent >= 1 && shape.exponent <= 10))
        throw InvalidInput(text("superellipsoid: exponent ", shape.exponent, " must be in [1, 10]"));
    return closed_body(triangles, [shape](double along, double around) {
        const double a = pi * along, b = pi * around;
        const Eigen::Array3d d(-std::cos(a), std::sin(a) * std::sin(b), std::sin(a) * std::cos(b));
        const double size = std::pow(d.abs().pow(shape.exponent).sum(), 1 / shape.exponent);
        return Eigen::Vector3d(shape.half_axes.array() * d / size);
    });
}

TriMesh tube(int triangles, const TubeShape& shape) {
    const double round = 0.5 * (shape.half_width + shape.half_height);
    return closed_body(triangles, [shape, round](double along, double around) {
        const Eigen::Vector2d m = capsule_meridian(shape.length / round, along);
        return Eigen::Vector3d(round * m[0], shape.half_width * m[1] * std::sin(pi * around),
                               shape.half_height * m[1] * std::cos(pi * around));
    });
}

TriMesh fuselage(int triangles, const FuselageShape& shape) {
    return closed_body(triangles, [shape](double along, double around) {
        const double x = 0.5 * (1 - std::cos(pi * along));  // share of the length, dense at the round ends
        double r = 1;
        if (x < shape.nose) r = std::sqrt(std::max(0.0, 1 - std::pow(1 - x / shape.nose, 2)));
        if (x > 1 - shape.tail) r = std::sqrt(std::max(0.0, 1 - std::pow(1 - (1 - x) / shape.tail, 2)));
        const double middle = 0.5 * (shape.nacelle_begin + shape.nacelle_end);
        const double s = (x - middle) / (0.5 * (shape.nacelle_end - shape.nacelle_begin));
        const double q = (180 * around - shape.nacelle_angle_deg) / shape.nacelle_half_angle_deg;
        r = shape.radius * (r + shape.nacelle_height * nacelle(s, q));
        return Eigen::Vector3d(shape.length * x, r * std::sin(pi * around), r * std::cos(pi * around));
    });
}

}  // namespace strake::example
