#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/surface_distance.hpp"
#include "core/mesh/surface_unmap.hpp"
#include "core/mesh/topology.hpp"
#include "objectives/quantity/closed.hpp"
#include "python/bindings.hpp"

namespace strake::python {
namespace {

using namespace py::literals;

using SurfaceClass = py::class_<TriMesh, SurfacePointer>;

SurfacePointer make_surface(const Rows& vertices, const py::object& triangles) {
    check_rows(vertices, -1, "Surface: vertices");
    auto mesh = std::make_shared<TriMesh>();
    mesh->triangles = corners_of(triangles, vertices.rows(), "Surface: triangles");
    mesh->vertices = vertices;
    return mesh;
}

double closed_volume(const TriMesh& mesh) {
    require_closed("Surface.volume", mesh, {});
    return enclosed_volume(mesh);
}

py::dict distance(const TriMesh& from, const TriMesh& to) {
    SurfaceDistance d;
    {
        const py::gil_scoped_release release;
        d = surface_distance(from, to);
    }
    return py::dict("max"_a = d.max, "mean"_a = d.mean, "rms"_a = d.rms, "at"_a = d.at, "nearest"_a = d.nearest,
                    "triangle"_a = d.triangle, "at_vertices"_a = d.at_vertices);
}

void bind_map(py::module_& m) {
    py::class_<SurfaceMap>(m, "SurfaceMap",
                           R"(Moves other points the way a surface moves: a finer surface, the points of a volume mesh.

    along = strake.SurfaceMap(surface, points)
    points_then = along.moved(result.vertices)

The map is linear in the displacement of the vertices, exact at the vertices, and decays to zero at `reach` diagonals
of the surface. `transpose` maps gradients back exactly. P is the number of points, n the number of vertices.)")
        .def(py::init(
                 [](const TriMesh& rest, const Rows& points, double reach, const std::optional<PlaneTuple>& symmetry) {
                     check_rows(points, -1, "SurfaceMap: points");
                     const SurfaceMapOptions options{reach, plane_of(symmetry)};
                     const py::gil_scoped_release release;
                     return std::make_unique<SurfaceMap>(rest, points, options);
                 }),
             "rest"_a, "points"_a, py::kw_only(), "reach"_a = 1.0, "symmetry"_a = py::none(),
             R"(__init__(self, rest, points, *, reach=1.0, symmetry=None)
--

`rest`: the start Surface.
`points`: P x 3 floats, the start positions of the points, in the surface's unit.
`reach`: distance beyond which nothing moves, in diagonals of the surface.
`symmetry`: (normal, offset) of the symmetry plane of half a body: normal . x = offset.)")
        .def_property_readonly("distances", &SurfaceMap::distances, py::return_value_policy::reference_internal,
                               "P floats: the distance of each point from the start surface. Read-only.")
        .def(
            "moved",
            [](const SurfaceMap& map, const Rows& vertices) {
                check_rows(vertices, map.num_vertices(), "SurfaceMap.moved: vertices");
                const py::gil_scoped_release release;
                return map.moved(vertices);
            },
            "vertices"_a, R"(moved(self, vertices)
--

Positions of the points (P x 3 floats) for surface vertices at `vertices` (n x 3 floats).)")
        .def(
            "apply",
            [](const SurfaceMap& map, const Rows& displacement) {
                check_rows(displacement, map.num_vertices(), "SurfaceMap.apply: displacement");
                const py::gil_scoped_release release;
                return map.apply(displacement);
            },
            "displacement"_a, R"(apply(self, displacement)
--

Displacements of the points (P x 3 floats) from the `displacement` of the vertices (n x 3 floats).)")
        .def(
            "transpose",
            [](const SurfaceMap& map, const Rows& sensitivities) {
                check_rows(sensitivities, map.num_points(), "SurfaceMap.transpose: sensitivities");
                const py::gil_scoped_release release;
                return map.transpose(sensitivities);
            },
            "sensitivities"_a, R"(transpose(self, sensitivities)
--

dJ/dv at the vertices (n x 3 floats) from `sensitivities` dJ/dp at the points (P x 3 floats).)");
}

void bind_measures(SurfaceClass& surface) {
    surface.def_property_readonly("num_vertices", &TriMesh::num_vertices, "n, the number of vertices.")
        .def_property_readonly("num_triangles", &TriMesh::num_triangles, "m, the number of triangles.")
        .def_property_readonly("area", &surface_area, "Float: area of all triangles, in unit squared.")
        .def_property_readonly("volume", &closed_volume,
                               "Float: enclosed volume, in unit cubed. Raises InvalidInput if the surface is open.")
        .def_property_readonly("diagonal", &box_diagonal,
                               "Float: diagonal of the bounding box, the reference of many relative lengths.")
        .def_property_readonly(
            "box",
            [](const TriMesh& s) {
                const Box box = bounding_box(s);
                return std::make_pair(box.min, box.max);
            },
            "Two arrays of 3 floats: the smallest and the largest x, y, z.")
        .def_property_readonly(
            "is_closed", [](const TriMesh& s) { return topology(s, adjacency(s)).closed; },
            "True if every edge has two consistently oriented triangles.")
        .def("normals", &triangle_normals, R"(normals(self)
--

Unit normals of the triangles, m x 3 floats.)")
        .def("areas", &triangle_areas, R"(areas(self)
--

Areas of the triangles, m floats, in unit squared.)")
        .def("centroids", &triangle_centroids, R"(centroids(self)
--

Centroids of the triangles, m x 3 floats.)")
        .def("distance", &distance, "other"_a, R"(distance(self, other)
--

Distance from this surface to the Surface `other`, sampled at vertices, edge midpoints and centroids: a dict with max, mean
and rms (floats, in the surface's unit), at (the point of the maximum), nearest (its closest point on `other`), triangle
(of `other`, containing that point) and at_vertices (n floats). It is one-sided; for the other side, swap the two.)");
}

}  // namespace

void bind_surface(py::module_& m) {
    SurfaceClass surface(m, "Surface",
                         R"(A triangulated surface of n vertices and m triangles.

    surface = strake.Surface(vertices, triangles)
    higher = surface.with_vertices(surface.vertices + [0, 0, 1])

A surface is immutable; `with_vertices` makes another one with the same triangles. Lengths are in the unit of the
vertices.)");
    surface
        .def(py::init(&make_surface), "vertices"_a, "triangles"_a, R"(__init__(self, vertices, triangles)
--

`vertices`: n x 3 floats. `triangles`: m x 3 whole numbers, the vertex numbers of the corners, from 0,
counter-clockwise seen from outside. Both are copied. Raises InvalidInput naming the wrong entry.)")
        .def_property_readonly(
            "vertices", [](const TriMesh& s) -> const Points& { return s.vertices; },
            py::return_value_policy::reference_internal, "n x 3 floats: a read-only view of the surface's own memory.")
        .def_property_readonly(
            "triangles", [](const TriMesh& s) -> const Triangles& { return s.triangles; },
            py::return_value_policy::reference_internal,
            "m x 3 int32: vertex numbers of the corners from 0, a read-only view of the surface's own memory.")
        .def(
            "with_vertices",
            [](const TriMesh& s, const Rows& vertices) {
                check_rows(vertices, s.num_vertices(), "Surface.with_vertices");
                return std::make_shared<TriMesh>(with_vertices(s, vertices));
            },
            "vertices"_a, R"(with_vertices(self, vertices)
--

A Surface with the same triangles and other `vertices` (n x 3 floats).)")
        .def(
            "__repr__",
            [](const TriMesh& s) {
                return text("<strake.Surface: ", s.num_vertices(), " vertices, ", s.num_triangles(), " triangles>");
            },
            repr_doc);
    bind_measures(surface);
    m.def(
        "read_surface",
        [](const std::filesystem::path& file) {
            const py::gil_scoped_release release;
            return std::make_shared<TriMesh>(read_surface(file).mesh);
        },
        "file"_a);
    m.def(
        "write_surface",
        [](const std::filesystem::path& file, const TriMesh& surface) {
            const py::gil_scoped_release release;
            write_surface(file, surface, format_of(file));
        },
        "file"_a, "surface"_a);
    bind_map(m);
}

}  // namespace strake::python
