#include "core/mesh/pair_test.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

/// The only file that includes CGAL, which compiles slowly.
namespace strake {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Segment = Kernel::Segment_3;
using Triangle = Kernel::Triangle_3;

struct Face {
    std::array<Point, 3> at;

    explicit Face(const Corners& c) {
        for (int k = 0; k < 3; ++k) at[k] = Point(c.at[k].x(), c.at[k].y(), c.at[k].z());
    }
    bool is_degenerate() const { return CGAL::collinear(at[0], at[1], at[2]); }
    Triangle triangle() const { return {at[0], at[1], at[2]}; }
    Segment opposite(int corner) const { return {at[(corner + 1) % 3], at[(corner + 2) % 3]}; }
};

/// Any other common part reaches the edge opposite to the vertex in one of them.
bool meet_beside_corner(const Face& s, int s_corner, const Face& t, int t_corner) {
    return CGAL::do_intersect(s.triangle(), t.opposite(t_corner)) ||
           CGAL::do_intersect(t.triangle(), s.opposite(s_corner));
}

/// Two triangles with a common edge meet elsewhere only when folded flat onto each other.
bool overlap_beside_edge(const Face& s, int s_apex, const Face& t, int t_apex) {
    const Point &a = s.at[(s_apex + 1) % 3], &b = s.at[(s_apex + 2) % 3];
    const Point &p = s.at[s_apex], &q = t.at[t_apex];
    return CGAL::coplanar(a, b, p, q) && CGAL::coplanar_orientation(a, b, p, q) == CGAL::POSITIVE;
}

}  // namespace

Meeting exact_meeting(const Corners& s, const Corners& t) {
    const Face s_face(s), t_face(t);
    if (s_face.is_degenerate() || t_face.is_degenerate()) return Meeting::none;
    int num_shared = 0, s_corner = 0, t_corner = 0;  // of the last shared corner
    int s_sum = 0, t_sum = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (s.id[i] == t.id[j]) {
                ++num_shared;
                s_sum += s_corner = i;
                t_sum += t_corner = j;
            }
    if (num_shared == 0)
        return CGAL::do_intersect(s_face.triangle(), t_face.triangle()) ? Meeting::apart : Meeting::none;
    const bool adjacent = (num_shared == 1 && meet_beside_corner(s_face, s_corner, t_face, t_corner)) ||
                          (num_shared == 2 && overlap_beside_edge(s_face, 3 - s_sum, t_face, 3 - t_sum));
    return adjacent ? Meeting::adjacent : Meeting::none;
}

}  // namespace strake
