#include "cases/geometry/business_jet.hpp"

#include "cases/geometry/closed_body.hpp"
#include "cases/geometry/wing.hpp"
#include "core/error.hpp"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Surface_mesh.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

namespace strake::example {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

constexpr double pi = std::numbers::pi;

/// A lifting surface between two ends: leading edge and chord at each, section perpendicular to the span.
struct Panel {
    Eigen::Vector3d root, tip;  ///< leading edges
    double root_chord, tip_chord;
    double thickness;
    Eigen::Vector3d normal;  ///< of the chord plane
};

/// Points around the section at the share t of the way from root to tip, from the trailing edge over the top.
std::vector<Eigen::Vector3d> section_points(const Panel& panel, double t, int chordwise) {
    const Eigen::Vector3d leading = (1 - t) * panel.root + t * panel.tip;
    const double chord = (1 - t) * panel.root_chord + t * panel.tip_chord;
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < 2 * chordwise; ++k) {
        const double x = k == 0 ? 1 : k == chordwise ? 0 : 0.5 * (1 + std::cos(pi * k / chordwise));
        const double z = (k <= chordwise ? 1 : -1) * naca_half_thickness(panel.thickness, x);
        points.push_back(leading + chord * (x * Eigen::Vector3d::UnitX() + z * panel.normal));
    }
    return points;
}

/// Triangles across the section whose points begin at `first`; facing inward along the way of the panels unless
/// `turned`.
void add_cap(std::vector<std::array<int, 3>>& triangles, int first, int chordwise, bool turned) {
    const int around = 2 * chordwise;
    const auto upper = [&](int i) { return first + i; };
    const auto lower = [&](int i) { return first + (around - i) % around; };
    const auto add = [&](int a, int b, int c) {
        triangles.push_back(turned ? std::array{a, c, b} : std::array{a, b, c});
    };
    for (int k = 0; k < chordwise; ++k) {
        if (k > 0) add(upper(k), upper(k + 1), lower(k));
        if (k + 1 < chordwise) add(lower(k), upper(k + 1), lower(k + 1));
    }
}

TriMesh mesh_of(const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 3>>& triangles) {
    TriMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t k = 0; k < points.size(); ++k) mesh.vertices.row(k) = points[k].transpose();
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        mesh.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
    return mesh;
}

/// Through the sections of the panels, one after the other. Closed: caps at both ends. Cells are long across the flow,
/// as converters like them.
TriMesh panel_surface(const std::vector<Panel>& panels, int chordwise, int spanwise) {
    const int around = 2 * chordwise;
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 3>> triangles;
    for (std::size_t p = 0; p < panels.size(); ++p)
        for (int s = p == 0 ? 0 : 1; s <= spanwise; ++s)
            for (const auto& point : section_points(panels[p], static_cast<double>(s) / spanwise, chordwise))
                points.push_back(point);
    const int sections = static_cast<int>(points.size()) / around;
    for (int s = 0; s + 1 < sections; ++s)
        for (int k = 0; k < around; ++k) {
            const int a = s * around + k, b = s * around + (k + 1) % around;
            triangles.push_back({a, a + around, b});
            triangles.push_back({b, a + around, b + around});
        }
    add_cap(triangles, 0, chordwise, false);
    add_cap(triangles, (sections - 1) * around, chordwise, true);
    return mesh_of(points, triangles);
}

/// Round, with a drooped nose and a tail that rises.
TriMesh fuselage_surface(int along, int around) {
    constexpr double length = 20, radius = 1.05;
    TriMesh mesh;
    mesh.vertices.resize((along - 1) * around + 2, 3);
    for (int i = 1; i < along; ++i) {
        const double s = static_cast<double>(i) / along, x = 0.5 * (1 - std::cos(pi * s));
        double r = 1, rise = 0;
        if (x < 0.2) r = std::pow(1 - std::pow(1 - x / 0.2, 2), 0.6), rise = -0.25 * std::pow(1 - x / 0.2, 2);
        if (x > 0.62) {
            const double t = (x - 0.62) / 0.38;
            r = std::sqrt(1 - t * t * (0.98 * 0.98) - 0.0396 * std::pow(t, 8)), rise = 0.55 * t * t;
        }
        for (int k = 0; k < around; ++k) {
            const double a = 2 * pi * k / around;
            mesh.vertices.row((i - 1) * around + k) << length * x, radius * r * std::sin(a),
                radius * (r * std::cos(a) + rise);
        }
    }
    const int nose = (along - 1) * around, tail = nose + 1;
    mesh.vertices.row(nose) << 0, 0, -0.25 * radius;
    mesh.vertices.row(tail) << length, 0, 0.55 * radius;
    std::vector<std::array<int, 3>> triangles;
    for (int k = 0; k < around; ++k) {
        const int next = (k + 1) % around, last = (along - 2) * around;
        triangles.push_back({nose, k, next});
        triangles.push_back({tail, last + next, last + k});
        for (int i = 0; i + 2 < along; ++i) {
            const int a = i * around + k, b = i * around + next;
            triangles.push_back({a, a + around, b});
            triangles.push_back({b, a + around, b + around});
        }
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        mesh.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
    return mesh;
}

Mesh exact(const TriMesh& mesh) {
    Mesh result;
    std::vector<Mesh::Vertex_index> vertex;
    for (int k = 0; k < mesh.num_vertices(); ++k)
        vertex.push_back(result.add_vertex({mesh.vertices(k, 0), mesh.vertices(k, 1), mesh.vertices(k, 2)}));
    for (int t = 0; t < mesh.num_triangles(); ++t)
        result.add_face(vertex[mesh.triangles(t, 0)], vertex[mesh.triangles(t, 1)], vertex[mesh.triangles(t, 2)]);
    return result;
}

TriMesh rounded(const Mesh& exact) {
    TriMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(exact.number_of_vertices()), 3);
    std::vector<int> number(exact.num_vertices());
    int k = 0;
    for (const auto v : exact.vertices()) {
        const Kernel::Point_3& p = exact.point(v);
        mesh.vertices.row(k) << CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z());
        number[v.idx()] = k++;
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(exact.number_of_faces()), 3);
    int t = 0;
    for (const auto f : exact.faces()) {
        int corner = 0;
        for (const auto v : exact.vertices_around_face(exact.halfedge(f)))
            mesh.triangles(t, corner++) = number[v.idx()];
        ++t;
    }
    return mesh;
}

/// The two parts of a triangle whose edge {a, b} is cut at the vertex `middle`.
void add_halves(std::vector<std::array<int, 3>>& triangles, const Eigen::RowVector3i& triangle, std::array<int, 2> edge,
                int middle) {
    for (int k = 0; k < 3; ++k) {
        const int p = triangle[k], q = triangle[(k + 1) % 3], apex = triangle[(k + 2) % 3];
        if (std::minmax(p, q) != std::minmax(edge[0], edge[1])) continue;
        triangles.push_back({p, middle, apex});
        triangles.push_back({middle, q, apex});
    }
}

/// Splits edges a hair from one of their ends (needles), every third in its middle.
TriMesh with_needles(const TriMesh& mesh, int count) {
    std::map<std::array<int, 2>, std::vector<int>> triangles_of;
    const auto edge = [&](int t, int c) {
        const int a = mesh.triangles(t, c), b = mesh.triangles(t, (c + 1) % 3);
        return std::array{std::min(a, b), std::max(a, b)};
    };
    for (int t = 0; t < mesh.num_triangles(); ++t)
        for (int c = 0; c < 3; ++c) triangles_of[edge(t, c)].push_back(t);
    std::mt19937 random(1);
    std::vector<char> is_used(mesh.num_triangles(), 0);
    std::vector<std::array<int, 3>> triangles;
    std::vector<Eigen::Vector3d> points;
    for (int tries = 0; tries < 20 * count && static_cast<int>(points.size()) < count; ++tries) {
        const int t = static_cast<int>(random() % mesh.num_triangles()), c = static_cast<int>(random() % 3);
        const std::vector<int>& two = triangles_of[edge(t, c)];
        if (two.size() != 2 || is_used[two[0]] || is_used[two[1]]) continue;
        const double share = points.size() % 3 == 0 ? 0.5 : 1e-3;
        const int a = mesh.triangles(t, c), b = mesh.triangles(t, (c + 1) % 3);
        const int middle = mesh.num_vertices() + static_cast<int>(points.size());
        points.emplace_back((1 - share) * mesh.vertices.row(a) + share * mesh.vertices.row(b));
        for (const int side : two) {
            is_used[side] = 1;
            add_halves(triangles, mesh.triangles.row(side), {a, b}, middle);
        }
    }
    for (int t = 0; t < mesh.num_triangles(); ++t)
        if (!is_used[t]) triangles.push_back({mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)});
    std::vector<Eigen::Vector3d> all;
    for (const auto& row : mesh.vertices.rowwise()) all.emplace_back(row);
    all.insert(all.end(), points.begin(), points.end());
    return mesh_of(all, triangles);
}

}  // namespace

TriMesh business_jet(int triangles) {
    if (triangles < 5000 || triangles > 1'000'000)
        throw InvalidInput(text("triangles = ", triangles, " must be in [5000, 1000000]"));
    const double fine = std::sqrt(triangles / 115'000.0);  // cell counts are those of 115 000 triangles
    const auto cells = [fine](int count) { return std::max(4, static_cast<int>(std::lround(count * fine))); };
    using V = Eigen::Vector3d;
    const V up = V::UnitZ(), left = -V::UnitY();
    // Wing and tail are one surface from tip to tip, so that nothing has to be joined on the plane of symmetry.
    const auto both_sides = [&](const V& root, const V& tip, double root_chord, double tip_chord, double thickness) {
        const V other(tip.x(), -tip.y(), tip.z());
        return std::vector<Panel>{{other, root, tip_chord, root_chord, thickness, up},
                                  {root, tip, root_chord, tip_chord, thickness, up}};
    };
    std::vector<TriMesh> parts;
    parts.push_back(fuselage_surface(cells(90), cells(120)));
    parts.push_back(panel_surface(both_sides({7.2, 0, -0.72}, {11.4, 9.2, 0.0}, 4.2, 1.3, 0.12), cells(70), cells(75)));
    const std::vector<Panel> fin{{{16.0, 0, 0.6}, {18.6, 0, 4.05}, 3.2, 2.1, 0.11, left}};
    parts.push_back(panel_surface(fin, cells(50), cells(50)));
    parts.push_back(panel_surface(both_sides({18.55, 0, 3.93}, {19.9, 3.6, 3.8}, 1.9, 0.9, 0.1), cells(45), cells(45)));
    for (const double side : {-1.0, 1.0}) {
        TriMesh engine = tube(static_cast<int>(9'000 * fine * fine) + 600, {3.4, 0.56, 0.56});
        engine.vertices.rowwise() += Eigen::RowVector3d(13.6, side * 1.75, 0.75);
        parts.push_back(std::move(engine));
        const V inner(14.35, side * 0.5, 0.62), outer(14.45, side * 1.6, 0.75);
        const std::vector<Panel> pylon{side > 0 ? Panel{inner, outer, 2.0, 1.8, 0.12, up}
                                                : Panel{outer, inner, 1.8, 2.0, 0.12, up}};
        parts.push_back(panel_surface(pylon, cells(30), cells(24)));
    }
    Mesh whole = exact(parts.front());
    for (std::size_t p = 1; p < parts.size(); ++p) {
        Mesh part = exact(parts[p]), joined;
        if (!CGAL::Polygon_mesh_processing::corefine_and_compute_union(whole, part, joined))
            throw InvalidInput(text("business_jet: part ", p, " could not be joined"));
        joined.collect_garbage();
        whole = std::move(joined);
    }
    return with_needles(rounded(whole), triangles / 50);
}

}  // namespace strake::example
