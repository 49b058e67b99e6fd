#include "cases/geometry/lifting_body.hpp"

#include "cases/geometry/rows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake::example {
namespace {

/// 0 below `begin`, 1 above `end`, twice continuously differentiable between.
double ramp(double x, double begin, double end) {
    const double s = std::clamp((x - begin) / (end - begin), 0.0, 1.0);
    return s * s * s * (10 + s * (-15 + 6 * s));
}

/// Half axis of a conic at x: sqrt(2 r x + (end^2 - 2 r) x^2), radius of curvature r at the nose, `end` at x = 1.
double conic(double x, double nose_radius, double end) {
    return std::sqrt(std::max(0.0, x * (2 * nose_radius + x * (end * end - 2 * nose_radius))));
}

enum class Side { upper = 1, lower = -1 };

/// Cross-sections at x in [0, 1] (lengths over the body's length), right half. Across, a point is named by its share
/// of the camber line's length, 0 on the symmetry plane and 1 on the chine.
class Skin {
public:
    explicit Skin(const LiftingBodyShape& shape) : shape_(shape) {}

    Eigen::Vector3d at(double x, double share, Side side) const {
        const double body = conic(x, shape_.nose_radius, shape_.half_width);
        const double chine = body + shape_.winglet_span * ramp(x, 0.60, 0.86);
        const double q = share * chine;
        const Camber camber = camber_line(x, q, body);
        const double t = share == 1 ? 0.0 : double(static_cast<int>(side)) * thickness(x, q, body, chine, side);
        return shape_.length *
               Eigen::Vector3d(x, camber.y - t * std::sin(camber.angle), camber.z + t * std::cos(camber.angle));
    }

private:
    struct Camber {
        double y, z, angle;
    };
    /// Straight, then a circular arc about the body's edge up to the winglet's cant, then straight.
    Camber camber_line(double x, double q, double body) const {
        const double cant = shape_.winglet_cant_deg * std::numbers::pi / 180 * ramp(x, 0.42, 0.66);
        const double begin = std::max(0.0, body - 0.045), end = body + 0.055;
        if (q <= begin || cant == 0) return {q, 0, 0};
        const double u = std::min(q, end) - begin, angle = cant * u / (end - begin);
        const double half_sine = std::sin(angle / 2);
        const double rest = std::max(0.0, q - end);
        return {begin + u * std::sin(angle) / angle + rest * std::cos(angle),
                u * 2 * half_sine * half_sine / angle + rest * std::sin(angle), angle};
    }
    /// Elliptic at the nose, then parabolic with sharp chines; where winglets grow, the body's part runs out smoothly
    /// on a plate of constant thickness with a wedge at its edge.
    double thickness(double x, double q, double body, double chine, Side side) const {
        const bool upper = side == Side::upper;
        const double height = upper ? conic(x, 0.014, 0.10) : conic(x, 0.010, 0.05);
        const double eta = body > 0 ? std::min(1.0, q / body) : 1.0;
        const double round = std::sqrt(1 - eta * eta);
        const double sharp = upper ? 1 - eta * eta : 1 - eta * eta * eta * eta;  // the belly is flatter
        const double fade = ramp(x, 0.40, 0.65);
        const double aft = ramp(x, 0.0, 0.30);
        const double profile = (1 - aft) * round + aft * sharp * (1 - fade + fade * sharp);
        const double plate = 0.012 * ramp(x, 0.15, 0.55) * (1 - std::exp(-(chine - q) / 0.02));
        return height * profile + plate + (upper ? canopy(x, q) : 0.0);
    }
    double canopy(double x, double q) const {
        const double u = q / 0.08;
        if (u >= 1) return 0;
        const double across = 1 - u * u;
        return shape_.canopy_height * ramp(x, 0.24, 0.39) * (1 - ramp(x, 0.40, 0.88)) * across * across * across;
    }
    LiftingBodyShape shape_;
};

/// Stations from nose to base, spaced evenly along the mean of belly, deck and chine.
std::vector<double> stations(const Skin& skin, double spacing) {
    constexpr int samples = 4000;
    // Parameter squared: the nose is round.
    const auto meridian = [&](double share, Side side) {
        return arc_table([&](double p) { return skin.at(p * p, share, side); }, samples);
    };
    const ArcTable top = meridian(0, Side::upper), bottom = meridian(0, Side::lower), chine = meridian(1, Side::upper);
    const ArcTable mean = mean_of(mean_of(top, bottom), chine);
    const int rows = std::max(8, static_cast<int>(std::lround(mean.total() / spacing)));
    std::vector<double> x;
    for (int r = 0; r <= rows; ++r) {
        const double p = mean.parameter(mean.total() * r / rows);
        x.push_back(r == 0 ? 0 : r == rows ? 1 : p * p);
    }
    return x;
}

struct Section {
    std::vector<int> upper, lower;  ///< from the symmetry plane to the chine, which they share
};

Section add_section(SurfaceBuilder& builder, const Skin& skin, double x, double edge_length) {
    const int samples = std::max(400, static_cast<int>(8 / edge_length));
    const ArcTable table = mean_of(arc_table([&](double s) { return skin.at(x, s, Side::upper); }, samples),
                                   arc_table([&](double s) { return skin.at(x, s, Side::lower); }, samples));
    const int pieces = std::max(2, static_cast<int>(std::lround(table.total() / edge_length)));
    Section section;
    for (int k = 0; k < pieces; ++k) {
        const double share = k == 0 ? 0 : table.parameter(table.total() * k / pieces);
        section.upper.push_back(builder.add(skin.at(x, share, Side::upper)));
        section.lower.push_back(builder.add(skin.at(x, share, Side::lower)));
    }
    const int chine = builder.add(skin.at(x, 1, Side::upper));
    section.upper.push_back(chine);
    section.lower.push_back(chine);
    return section;
}

/// Closes the last section by columns from the upper to the lower side.
void add_base(SurfaceBuilder& builder, const Section& rim, double edge_length) {
    std::vector<int> last;
    for (std::size_t k = 0; k < rim.upper.size(); ++k) {
        const Eigen::Vector3d a = builder.vertices[rim.upper[k]], b = builder.vertices[rim.lower[k]];
        std::vector<int> column{rim.upper[k]};
        if (rim.upper[k] != rim.lower[k]) {
            const int pieces = std::max(1, static_cast<int>(std::lround((b - a).norm() / edge_length)));
            for (int i = 1; i < pieces; ++i) column.push_back(builder.add(a + (b - a) * i / pieces));
            column.push_back(rim.lower[k]);
        }
        if (k > 0) builder.stitch(last, column, false);
        last = std::move(column);
    }
}

TriMesh lifting_body_of_edge_length(const LiftingBodyShape& shape, double edge_length) {
    const Skin skin(shape);
    SurfaceBuilder builder{.mirror_axis = 1};
    const int nose = builder.add(skin.at(0, 1, Side::upper));
    Section last{{nose}, {nose}};
    const std::vector<double> x = stations(skin, 0.87 * edge_length);
    for (std::size_t r = 1; r < x.size(); ++r) {
        Section next = add_section(builder, skin, x[r], edge_length);
        builder.stitch(last.upper, next.upper, true);
        builder.stitch(last.lower, next.lower, false);
        last = std::move(next);
    }
    add_base(builder, last, edge_length);
    builder.mirror();
    return builder.mesh();
}

}  // namespace

TriMesh lifting_body(int triangles, const LiftingBodyShape& shape) {
    const double first = shape.length * std::sqrt(1.0 / (0.433 * triangles));
    return with_triangle_count(triangles, 1500, first,
                               [&](double edge_length) { return lifting_body_of_edge_length(shape, edge_length); });
}

LiftingBodyShape winged_vehicle() {
    return {
        .nose_radius = 0.015, .half_width = 0.10, .canopy_height = 0.03, .winglet_span = 0.26, .winglet_cant_deg = 6};
}

}  // namespace strake::example
