// The isotropic remeshing of CGAL as Debian ships it, for comparison: cgal_remesh IN OUT LENGTH ANGLE_DEG MODE
// ITERATIONS MODE protect: creases are constrained and protected, split to the length before, as its manual asks;
// constrain: constrained, but free to be split and collapsed. Prints the CPU seconds of reading, remeshing and writing.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/IO/polygon_mesh_io.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

using Mesh = CGAL::Surface_mesh<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3>;
namespace pmp = CGAL::Polygon_mesh_processing;

namespace {
double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }
}  // namespace

int main(int argc, char** argv) {
    if (argc != 7) {
        std::fputs("cgal_remesh IN OUT LENGTH ANGLE_DEG protect|constrain ITERATIONS\n", stderr);
        return 2;
    }
    const double length = std::atof(argv[3]), angle = std::atof(argv[4]), start = cpu();
    const bool protect = std::string(argv[5]) == "protect";
    Mesh mesh;
    if (!pmp::IO::read_polygon_mesh(argv[1], mesh)) {
        std::fprintf(stderr, "cgal_remesh: %s: not readable as a manifold\n", argv[1]);
        return 3;
    }
    const double read = cpu();
    auto is_crease = mesh.add_property_map<Mesh::Edge_index, bool>("e:crease", false).first;
    pmp::detect_sharp_edges(mesh, angle, is_crease);
    for (const auto e : mesh.edges())
        if (mesh.is_border(e)) is_crease[e] = true;
    if (protect) {
        std::vector<Mesh::Edge_index> creases;
        for (const auto e : mesh.edges())
            if (is_crease[e]) creases.push_back(e);
        pmp::split_long_edges(creases, length, mesh, CGAL::parameters::edge_is_constrained_map(is_crease));
    }
    pmp::isotropic_remeshing(mesh.faces(), length, mesh,
                             CGAL::parameters::number_of_iterations(std::atoi(argv[6]))
                                 .edge_is_constrained_map(is_crease)
                                 .protect_constraints(protect));
    const double remeshed = cpu();
    mesh.collect_garbage();
    if (!CGAL::IO::write_polygon_mesh(argv[2], mesh, CGAL::parameters::stream_precision(17))) return 4;
    std::printf("%.2f %.2f %.2f\n", read - start, remeshed - read, cpu() - remeshed);
    return 0;
}
