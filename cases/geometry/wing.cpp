#include "cases/geometry/wing.hpp"

#include "cases/geometry/rows.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace strake::example {
namespace {

constexpr double pi = std::numbers::pi;

/// The upper half of the wing over (chord fraction, span fraction): span fraction 1 is the outline of the tip. Equal
/// steps of the span fraction are equal lengths along the skin, over the wing and on around the tip.
class UpperSkin {
public:
    explicit UpperSkin(const WingShape& shape) : shape_(shape), tan_sweep_(std::tan(shape.sweep_deg * pi / 180)) {}

    Eigen::Vector3d at(double chordwise, double spanwise) const {
        const double tip_radius = chord(1) * naca_half_thickness(shape_.thickness, chordwise);
        const double along = spanwise * (shape_.semi_span + 0.5 * pi * tip_radius);
        if (along <= shape_.semi_span) {
            const double c = chord(along / shape_.semi_span);
            return {along * tan_sweep_ + chordwise * c, along, c * naca_half_thickness(shape_.thickness, chordwise)};
        }
        const double phi = (along - shape_.semi_span) / tip_radius;
        const double z = spanwise == 1 ? 0.0 : tip_radius * std::cos(phi);
        return {shape_.semi_span * tan_sweep_ + chordwise * chord(1), shape_.semi_span + tip_radius * std::sin(phi), z};
    }
    double chord(double share_of_span) const { return shape_.root_chord * (1 + share_of_span * (shape_.taper - 1)); }

private:
    WingShape shape_;
    double tan_sweep_;
};

/// Chord fraction from a row's parameter: squared, so that the round leading edge is sampled evenly.
double chordwise_of(double parameter) { return parameter * parameter; }

/// Points of one row from the leading edge to the trailing edge.
std::vector<int> add_row(SurfaceBuilder& builder, const UpperSkin& skin, double spanwise, double edge_length) {
    const Curve row = [&](double p) { return skin.at(chordwise_of(p), spanwise); };
    // Edges half as long at the leading edge, growing to full length within 8 % of the chord.
    const auto weight = [](double p) { return 1 / std::min(1.0, 0.5 + 0.5 * chordwise_of(p) / 0.08); };
    const int samples = std::max(400, static_cast<int>(8 / edge_length));
    const ArcTable table = arc_table(row, samples, weight);
    const int pieces = std::max(4, static_cast<int>(std::lround(table.total() / edge_length)));
    std::vector<int> points;
    for (int k = 0; k <= pieces; ++k)
        points.push_back(builder.add(k == 0        ? row(0)
                                     : k == pieces ? row(1)
                                                   : row(table.parameter(table.total() * k / pieces))));
    return points;
}

TriMesh wing_of_edge_length(const WingShape& shape, double edge_length) {
    const UpperSkin skin(shape);
    // Rows of equilateral triangles lie sqrt(3)/2 of an edge apart.
    const int rows = std::max(3, static_cast<int>(std::lround(shape.semi_span / (0.866 * edge_length))));
    SurfaceBuilder builder{.mirror_axis = 2};
    std::vector<int> last = add_row(builder, skin, 0, edge_length);
    for (int r = 1; r <= rows; ++r) {
        std::vector<int> next = add_row(builder, skin, double(r) / rows, edge_length);
        builder.stitch(last, next, false);
        last = std::move(next);
    }
    builder.mirror();
    return builder.mesh();
}

}  // namespace

double naca_half_thickness(double thickness, double x) {
    if (x <= 0 || x >= 1) return 0;
    return 5 * thickness * (0.2969 * std::sqrt(x) + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - x * 0.1036))));
}

TriMesh wing(int triangles, const WingShape& shape) {
    const double planform = shape.semi_span * shape.root_chord * (1 + shape.taper) / 2;
    return with_triangle_count(triangles, 1000, std::sqrt(2 * planform / (0.433 * triangles)),
                               [&](double edge_length) { return wing_of_edge_length(shape, edge_length); });
}

TriMesh naca_wing(double thickness, int panels_per_side, int span_cells, double span) {
    if (panels_per_side < 2) throw InvalidInput(text("panels_per_side = ", panels_per_side, " must be >= 2"));
    if (span_cells < 1) throw InvalidInput(text("span_cells = ", span_cells, " must be >= 1"));
    if (!(thickness > 0) || !(span > 0))
        throw InvalidInput(text("thickness = ", thickness, " and span = ", span, " must be > 0"));
    const int around = 2 * panels_per_side;  // from the trailing edge over the top to the nose and back below
    TriMesh mesh;
    mesh.vertices.resize((span_cells + 1) * around, 3);
    mesh.triangles.resize(2 * span_cells * around, 3);
    for (int s = 0; s <= span_cells; ++s)
        for (int k = 0; k < around; ++k) {
            const double x = k == 0 ? 1 : k == panels_per_side ? 0 : 0.5 * (1 + std::cos(pi * k / panels_per_side));
            const double z = naca_half_thickness(thickness, x);
            mesh.vertices.row(s * around + k) << x, span * s / span_cells, k <= panels_per_side ? z : -z;
        }
    int t = 0;
    for (int s = 0; s < span_cells; ++s)
        for (int k = 0; k < around; ++k) {
            const int a = s * around + k, b = s * around + (k + 1) % around, c = a + around, d = b + around;
            mesh.triangles.row(t++) << a, c, b;
            mesh.triangles.row(t++) << b, c, d;
        }
    return mesh;
}

}  // namespace strake::example
