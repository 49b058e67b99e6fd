#include "casefile/build/region_shapes.hpp"

#include "core/error.hpp"
#include "core/mesh/point_triangle.hpp"

#include <algorithm>
#include <limits>

namespace strake {
namespace {

using Eigen::Vector3d;

constexpr double border_rel = 1e-9;  ///< of the diagonal: points on the border are inside

/// One shape and one surface.
class Ground {
public:
    Ground(const RegionShape& shape, const TriMesh& mesh, double diagonal)
        : shape_(shape), mesh_(mesh), diagonal_(diagonal) {}

    double slack() const { return border_rel * diagonal_; }
    double radius(const SphereShape& sphere) const { return sphere.radius.in(diagonal_); }

    /// By how much the shape must grow to hold the point; <= 0 inside.
    double excess(const Vector3d& x) const {
        if (const auto* box = std::get_if<BoxShape>(&shape_))
            return std::max((box->min - x).maxCoeff(), (x - box->max).maxCoeff());
        if (const auto* sphere = std::get_if<SphereShape>(&shape_))
            return (x - sphere->center).norm() - radius(*sphere);
        const auto& plane = std::get<HalfSpace>(shape_);
        return (plane.above ? -1 : 1) * (plane.normal.dot(x) - plane.offset);
    }

    /// By how much it must grow to hold triangle t, or some point of it; never mind by how much if more than `enough`.
    double shortfall(int t, bool touches, double enough) const {
        double least = std::numeric_limits<double>::infinity(), largest = -least;
        for (int k = 0; k < 3; ++k) {
            const double e = excess(corner(t, k));
            least = std::min(least, e);
            largest = std::max(largest, e);
        }
        if (!touches) return largest;
        if (const auto* sphere = std::get_if<SphereShape>(&shape_))
            return std::min(least, closest_point_on_triangle(mesh_, t, sphere->center).distance - radius(*sphere));
        const auto* box = std::get_if<BoxShape>(&shape_);
        if (!box || least <= slack()) return least;
        if (meets(*box, t, 0)) return 0;
        if (gap(*box, t) >= enough) return least;
        double low = 0, high = least;  // it grows from one to the other
        for (int i = 0; i < 50; ++i) {
            const double mid = (low + high) / 2;
            (meets(*box, t, mid) ? high : low) = mid;
        }
        return high;
    }

private:
    Vector3d corner(int t, int k) const { return mesh_.vertices.row(mesh_.triangles(t, k)); }

    /// Between the boxes: the triangle's own distance is no smaller.
    double gap(const BoxShape& box, int t) const {
        Vector3d low = corner(t, 0), high = low;
        for (int k = 1; k < 3; ++k) low = low.cwiseMin(corner(t, k)), high = high.cwiseMax(corner(t, k));
        return std::max((box.min - high).maxCoeff(), (low - box.max).maxCoeff());
    }

    /// Some point of t lies in the box with every face moved outwards by `by`: what is left after cutting by each face.
    bool meets(const BoxShape& box, int t, double by) const {
        std::vector<Vector3d> left{corner(t, 0), corner(t, 1), corner(t, 2)};
        const double room = by + slack();
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {-1.0, 1.0}) {
                const double wall = (side < 0 ? -box.min[axis] : box.max[axis]) + room;
                std::vector<Vector3d> cut;
                for (std::size_t i = 0; i < left.size(); ++i) {
                    const Vector3d &p = left[i], &q = left[(i + 1) % left.size()];
                    const double at_p = wall - side * p[axis], at_q = wall - side * q[axis];
                    if (at_p >= 0) cut.push_back(p);
                    if ((at_p < 0) != (at_q < 0)) cut.emplace_back(p + at_p / (at_p - at_q) * (q - p));
                }
                left = std::move(cut);
                if (left.empty()) return false;
            }
        return true;
    }

    const RegionShape& shape_;
    const TriMesh& mesh_;
    double diagonal_;
};

}  // namespace

std::vector<int> triangles_in(const RegionShape& shape, const TriMesh& mesh, double diagonal, bool touches) {
    const Ground ground(shape, mesh, diagonal);
    std::vector<int> found;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (ground.shortfall(t, touches, ground.slack()) <= ground.slack()) found.push_back(t);
    return found;
}

NearestMiss nearest_miss(const RegionShape& shape, const TriMesh& mesh, double diagonal, bool touches) {
    const Ground ground(shape, mesh, diagonal);
    NearestMiss nearest;
    double least = std::numeric_limits<double>::infinity();
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const double by = ground.shortfall(t, touches, least);
        if (by < least) least = by, nearest.triangle = t;
    }
    nearest.shortfall = std::max(0.0, least);
    nearest.touching = static_cast<int>(triangles_in(shape, mesh, diagonal, true).size());
    return nearest;
}

std::string miss_words(const RegionShape& shape, const TriMesh& mesh, double diagonal, bool touches) {
    const NearestMiss nearest = nearest_miss(shape, mesh, diagonal, touches);
    if (nearest.triangle < 0) return "the surface has no triangles";
    // Rounded up: what is written here, typed into the case, is enough.
    const auto up = [](double x) {
        const double unit = std::pow(10, std::floor(std::log10(std::max(x, 1e-300))) - 3);
        return std::ceil(x / unit * (1 - 1e-12)) * unit;
    };
    const double by = up(nearest.shortfall);
    std::string words =
        text("triangle ", nearest.triangle, " comes nearest, and would ", touches ? "touch it" : "be inside");
    if (const auto* sphere = std::get_if<SphereShape>(&shape)) {
        const double now = sphere->radius.in(diagonal);
        words += text(" with a radius of ", up(now + nearest.shortfall), " (now ", now, ")");
    } else if (std::holds_alternative<BoxShape>(shape)) {
        words += text(" if each face of the box were ", by, " farther out");
    } else {
        words += text(" if the plane were moved by ", by);
    }
    if (!touches && nearest.touching > 0)
        words += text("; with touch: any, the region would hold ", nearest.touching,
                      nearest.touching == 1 ? " triangle" : " triangles");
    return words;
}

}  // namespace strake
