// The only file that includes CGAL's alpha wrap: GPL-3.0+, a minute to compile.
#include "core/wrap/alpha_wrap.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <array>
#include <ctime>
#include <vector>

namespace strake {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

struct OutOfTime {};

/// Of this thread, which is the one that wraps: what else the machine does is not counted.
double cpu_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Asked before each facet.
struct Watch : CGAL::Alpha_wraps_3::internal::Wrapping_default_visitor {
    double end;
    explicit Watch(double until) : end(until) {}
    template <class Wrapper, class Gate>
    void before_facet_treatment(const Wrapper&, const Gate&) {
        if (cpu_seconds() > end) throw OutOfTime{};
    }
};

}  // namespace

bool has_alpha_wrap() { return true; }

TriMesh alpha_wrap(const TriMesh& soup, double alpha, double offset, double max_seconds) {
    std::vector<Kernel::Point_3> points;
    for (int v = 0; v < soup.num_vertices(); ++v)
        points.emplace_back(soup.vertices(v, 0), soup.vertices(v, 1), soup.vertices(v, 2));
    std::vector<std::array<std::size_t, 3>> faces;
    for (int t = 0; t < soup.num_triangles(); ++t)
        faces.push_back({static_cast<std::size_t>(soup.triangles(t, 0)), static_cast<std::size_t>(soup.triangles(t, 1)),
                         static_cast<std::size_t>(soup.triangles(t, 2))});
    Watch watch(cpu_seconds() + max_seconds);
    Mesh wrap;
    try {
        CGAL::alpha_wrap_3(points, faces, alpha, offset, wrap, CGAL::parameters::default_values(),
                           CGAL::parameters::visitor(watch));
    } catch (const OutOfTime&) {
        return {};
    }
    TriMesh out;
    out.vertices.resize(static_cast<Eigen::Index>(wrap.number_of_vertices()), 3);
    std::vector<int> number(wrap.num_vertices(), -1);
    int count = 0;
    for (const auto v : wrap.vertices()) {
        out.vertices.row(count) << wrap.point(v).x(), wrap.point(v).y(), wrap.point(v).z();
        number[v] = count++;
    }
    out.triangles.resize(static_cast<Eigen::Index>(wrap.number_of_faces()), 3);
    Eigen::Index t = 0;
    for (const auto f : wrap.faces()) {
        int k = 0;
        for (const auto v : wrap.vertices_around_face(wrap.halfedge(f))) out.triangles(t, k++) = number[v];
        ++t;
    }
    return out;
}

}  // namespace strake
