#include "core/error.hpp"
#include "core/mesh/adjacency.hpp"
#include "core/mesh/geometry.hpp"
#include "core/mesh/io.hpp"
#include "core/mesh/surface_distance.hpp"
#include "core/mesh/surface_unmap.hpp"
#include "core/mesh/topology.hpp"
#include "objectives/closed.hpp"
#include "python/bindings.hpp"

namespace strake::python {
namespace {

using namespace py::literals;

SurfacePointer make_surface(const Rows& vertices, const Eigen::Ref<const Triangles>& triangles) {
    check_rows(vertices, -1, "Surface: vertices");
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k)
            if (triangles(t, k) < 0 || triangles(t, k) >= vertices.rows())
                throw InvalidInput(text("Surface: triangle ", t, " has vertex ", triangles(t, k), ", limits 0 and ",
                                        vertices.rows() - 1));
    auto mesh = std::make_shared<TriMesh>();
    mesh->vertices = vertices;
    mesh->triangles = triangles;
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
                           "Moves other points (a finer surface, the points of a volume mesh) as a surface moves.\n\n"
                           "The map is linear in the displacement of the vertices, exact on the surface, and fades to\n"
                           "nothing at `reach` diagonals of the surface; `transpose` carries gradients back exactly.")
        .def(py::init(
                 [](const TriMesh& rest, const Rows& points, double reach, const std::optional<PlaneTuple>& symmetry) {
                     const SurfaceMapOptions options{reach, plane_of(symmetry)};
                     const py::gil_scoped_release release;
                     return std::make_unique<SurfaceMap>(rest, points, options);
                 }),
             "rest"_a, "points"_a, py::kw_only(), "reach"_a = 1.0, "symmetry"_a = py::none(),
             "`rest`: the surface at the start. `points`: P x 3, where they are then.\n"
             "`symmetry`: (normal, offset) where the surface is half a body.")
        .def_property_readonly("distances", &SurfaceMap::distances, py::return_value_policy::reference_internal,
                               "Of the points from the surface at the start, P.")
        .def(
            "moved",
            [](const SurfaceMap& map, const Rows& vertices) {
                check_rows(vertices, map.num_vertices(), "SurfaceMap.moved: vertices");
                const py::gil_scoped_release release;
                return map.moved(vertices);
            },
            "vertices"_a, "Where the points are (P x 3) when the vertices are here (n x 3).")
        .def(
            "apply",
            [](const SurfaceMap& map, const Rows& displacement) {
                check_rows(displacement, map.num_vertices(), "SurfaceMap.apply: displacement");
                const py::gil_scoped_release release;
                return map.apply(displacement);
            },
            "displacement"_a, "Displacements of the points (P x 3) from those of the vertices (n x 3).")
        .def(
            "transpose",
            [](const SurfaceMap& map, const Rows& sensitivities) {
                check_rows(sensitivities, map.num_points(), "SurfaceMap.transpose: sensitivities");
                const py::gil_scoped_release release;
                return map.transpose(sensitivities);
            },
            "sensitivities"_a, "dJ/dv at the vertices (n x 3) from dJ/dp at the points (P x 3).");
}

}  // namespace

void bind_surface(py::module_& m) {
    py::class_<TriMesh, SurfacePointer>(
        m, "Surface",
        "A triangulated surface: `vertices` (n x 3, float64) and `triangles` (m x 3, int32, from 0).\n\n"
        "Both are read-only views of the surface's own memory. A surface never changes; `with_vertices` makes another\n"
        "one of the same triangles.")
        .def(py::init(&make_surface), "vertices"_a, "triangles"_a, "Copies both. Raises InvalidInput with the place.")
        .def_property_readonly(
            "vertices", [](const TriMesh& s) -> const Points& { return s.vertices; },
            py::return_value_policy::reference_internal, "n x 3, read-only view.")
        .def_property_readonly(
            "triangles", [](const TriMesh& s) -> const Triangles& { return s.triangles; },
            py::return_value_policy::reference_internal, "m x 3, read-only view.")
        .def_property_readonly("num_vertices", &TriMesh::num_vertices, "n")
        .def_property_readonly("num_triangles", &TriMesh::num_triangles, "m")
        .def_property_readonly("area", &surface_area, "Length squared.")
        .def_property_readonly("volume", &closed_volume, "Length cubed. Raises InvalidInput where the surface is open.")
        .def_property_readonly("diagonal", &box_diagonal, "Of the bounding box; many lengths are relative to it.")
        .def_property_readonly(
            "box",
            [](const TriMesh& s) {
                const Box box = bounding_box(s);
                return std::make_pair(box.min, box.max);
            },
            "Smallest and largest coordinates.")
        .def_property_readonly(
            "is_closed", [](const TriMesh& s) { return topology(s, adjacency(s)).closed; },
            "Every edge has two triangles that agree in orientation.")
        .def("normals", &triangle_normals, "Unit normals of the triangles, m x 3.")
        .def("areas", &triangle_areas, "Of the triangles, m.")
        .def("centroids", &triangle_centroids, "Of the triangles, m x 3.")
        .def(
            "with_vertices",
            [](const TriMesh& s, const Rows& vertices) {
                check_rows(vertices, s.num_vertices(), "Surface.with_vertices");
                return std::make_shared<TriMesh>(with_vertices(s, vertices));
            },
            "vertices"_a, "The same triangles on other vertices (n x 3).")
        .def("distance", &distance, "other"_a,
             "How far this surface is from another one: a dict of max, mean, rms, at, nearest, triangle and\n"
             "at_vertices, sampled at vertices, middles of edges and centroids. One way: call it both ways.")
        .def("__repr__", [](const TriMesh& s) {
            return text("<strake.Surface: ", s.num_vertices(), " vertices, ", s.num_triangles(), " triangles>");
        });
    m.def(
        "read_surface",
        [](const std::filesystem::path& file) {
            const py::gil_scoped_release release;
            return std::make_shared<TriMesh>(read_surface(file).mesh);
        },
        "file"_a, "Reads STL, OBJ, PLY, OFF, TRI, VTK, VTP, SU2, Gmsh or NASTRAN. Raises InputError with the place.");
    m.def(
        "write_surface",
        [](const std::filesystem::path& file, const TriMesh& surface) {
            const py::gil_scoped_release release;
            write_surface(file, surface, format_of(file));
        },
        "file"_a, "surface"_a, "Writes the format that the file's ending names, atomically.");
    bind_map(m);
}

}  // namespace strake::python
