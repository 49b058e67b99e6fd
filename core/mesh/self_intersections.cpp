#include "core/mesh/topology.hpp"
#include "core/mesh/weld.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>

/// The only file that includes CGAL, which compiles slowly.
namespace strake {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Segment = Kernel::Segment_3;
using Triangle = Kernel::Triangle_3;
using TriangleBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;

class PairTest {
public:
    explicit PairTest(const TriMesh& mesh) : triangles_(mesh.triangles) {
        // Vertices at the same place are shared: the two sides of a seam touch, they do not intersect.
        const std::vector<int> number = equal_points(mesh.vertices);
        for (int i = 0; i < triangles_.size(); ++i) triangles_.data()[i] = number[triangles_.data()[i]];
        points_.resize(static_cast<std::size_t>(mesh.num_vertices()));
        for (int v = 0; v < mesh.num_vertices(); ++v)
            points_[number[v]] = Point(mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2));
    }

    /// Three different vertices on one line, or fewer: no surface, told by topology().
    bool is_degenerate(int t) const { return CGAL::collinear(at(t, 0), at(t, 1), at(t, 2)); }

    TriangleBox box(int t) const { return {at(t, 0).bbox() + at(t, 1).bbox() + at(t, 2).bbox(), t}; }

    /// Sorts the pair into the result if it intersects.
    void examine(int s, int t, Intersections& found) const {
        int num_shared = 0, s_corner = 0, t_corner = 0;  // of the last shared vertex
        int s_sum = 0, t_sum = 0;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                if (triangles_(s, i) == triangles_(t, j)) {
                    ++num_shared;
                    s_sum += s_corner = i;
                    t_sum += t_corner = j;
                }
        if (num_shared == 0 && CGAL::do_intersect(triangle(s), triangle(t))) found.apart.push_back({s, t});
        const bool adjacent = (num_shared == 1 && meet_beside_vertex(s, s_corner, t, t_corner)) ||
                              (num_shared == 2 && overlap_beside_edge(s, 3 - s_sum, t, 3 - t_sum));
        if (adjacent) found.adjacent.push_back({s, t});
    }

private:
    const Point& at(int t, int corner) const { return points_[triangles_(t, corner)]; }
    Triangle triangle(int t) const { return {at(t, 0), at(t, 1), at(t, 2)}; }
    Segment opposite(int t, int corner) const { return {at(t, (corner + 1) % 3), at(t, (corner + 2) % 3)}; }

    /// What else they have in common reaches the edge opposite to the vertex in one of them.
    bool meet_beside_vertex(int s, int s_corner, int t, int t_corner) const {
        const Segment s_edge = opposite(s, s_corner), t_edge = opposite(t, t_corner);
        const Triangle s_face = triangle(s), t_face = triangle(t);
        return (CGAL::do_overlap(s_face.bbox(), t_edge.bbox()) && CGAL::do_intersect(s_face, t_edge)) ||
               (CGAL::do_overlap(t_face.bbox(), s_edge.bbox()) && CGAL::do_intersect(t_face, s_edge));
    }

    /// Two triangles with a common edge meet elsewhere only when folded flat onto each other.
    bool overlap_beside_edge(int s, int s_apex, int t, int t_apex) const {
        const Point &a = at(s, (s_apex + 1) % 3), &b = at(s, (s_apex + 2) % 3);
        const Point &p = at(s, s_apex), &q = at(t, t_apex);
        return CGAL::coplanar(a, b, p, q) && CGAL::coplanar_orientation(a, b, p, q) == CGAL::POSITIVE;
    }

    Triangles triangles_;  ///< on vertices without duplicates
    std::vector<Point> points_;
};

}  // namespace

Intersections intersections(const TriMesh& mesh) {
    const PairTest test(mesh);
    std::vector<TriangleBox> boxes;
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (!test.is_degenerate(t)) boxes.push_back(test.box(t));
    Intersections found;
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const TriangleBox& a, const TriangleBox& b) {
        test.examine(std::min(a.info(), b.info()), std::max(a.info(), b.info()), found);
    });
    std::sort(found.apart.begin(), found.apart.end());
    std::sort(found.adjacent.begin(), found.adjacent.end());
    return found;
}

std::vector<std::array<int, 2>> self_intersections(const TriMesh& mesh) { return intersections(mesh).apart; }

}  // namespace strake
