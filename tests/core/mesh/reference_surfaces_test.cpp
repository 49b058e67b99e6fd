#include "core/formats/io.hpp"
#include "core/mesh/topology.hpp"
#include "core/mesh/weld.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

/// Counts of public surfaces, taken with an independent program after a weld of equal coordinates; the files are
/// looked for in the folder STRAKE_DATA.
namespace strake {
namespace {

struct Expected {
    const char* file;
    int vertices, triangles, components, loops, nonmanifold_edges, misoriented_edges;
    double min_angle_deg;
    int intersections;
    bool closed;
};

void PrintTo(const Expected& e, std::ostream* out) { *out << e.file; }

const Expected table[] = {
    {"bunny70k_meshlab.ply", 34834, 69451, 1, 5, 0, 0, 0.513, 0, false},
    {"bunny_closed_cgal.off", 37706, 75408, 1, 0, 0, 0, 25, 0, true},
    {"bunny_pmp.off", 34835, 69666, 1, 0, 0, 0, 0.0071, 0, true},
    {"cgal_anchor.off", 519, 1050, 1, 0, 0, 0, 0.0166, 0, true},
    {"cgal_elephant-with-holes.off", 2733, 4463, 1, 106, 0, 0, 30, 0, false},
    {"cgal_fandisk_large.off", 15843, 31682, 1, 0, 0, 0, 30.4, 0, true},
    {"cgal_joint.off", 221, 446, 1, 0, 0, 0, 0.478, 0, true},
    {"citationX_raw.ply", 4501, 7928, 86, 120, 134, 22, 0.0254, 1767, false},
    {"dpw_w1_pypan.tri", 3321, 6479, 1, 1, 0, 0, 1.14, 0, false},
    {"generic_twin_manifold.obj", 9874, 19704, 12, 0, 0, 0, 0, 1, true},
    {"hsct_pypan.tri", 3333, 6474, 3, 1, 0, 0, 0.0974, 0, false},
    {"jet_engine_nacelle_machline.stl", 1440, 2880, 1, 0, 0, 0, 4.27, 0, true},
    {"oneraM6_pyhyp_small.ply", 15321, 30464, 1, 1, 0, 0, 0.12, 0, false},
    {"oneraM6_pyhyp_small_full.ply", 30466, 60928, 1, 0, 0, 0, 0.12, 0, true},
    {"oneraM6_su2_surface.stl", 1453, 2816, 1, 1, 0, 4, 0.824, 0, false},
    {"platonic_shelf_be.ply", 50, 80, 5, 0, 0, 0, 36, 0, true},
    {"supersonic_wing_body_pypan.stl", 11822, 23640, 1, 0, 0, 0, 0.0916, 0, true},
    {"three_element_wing_cpanel.tri", 5961, 11776, 3, 3, 94, 0, 8.01, 0, false},
    {"threeplugs_pynastran.tri", 5646, 11280, 3, 0, 0, 0, 1.47, 704, true},
    {"threeplugs_pynastran_bin.tri", 5646, 11280, 3, 0, 0, 0, 1.47, 704, true},
    {"turbineblade_vtkdata.ply", 99519, 199034, 1, 0, 0, 0, 0.644, 0, true},
    {"two_objects_mixed_case_trimesh.stl", 16, 24, 2, 0, 0, 0, 45, 0, true},
    {"wing717_pyhyp.ply", 12177, 24192, 1, 1, 0, 0, 0.124, 0, false},
    {"wing_c172_pygeo.stl", 1973, 3610, 3, 2, 0, 4, 0.0073, 0, false},
    {"x43_parts.ply", 2216, 4656, 6, 10, 456, 64, 0.398, 2565, false},
    {"zeroebwb_93k.ply", 46867, 93730, 1, 0, 0, 0, 6.13, 0, true},
};

class ReferenceSurfaces : public testing::TestWithParam<Expected> {};

TEST_P(ReferenceSurfaces, CountsAreThoseOfTheTable) {
    const char* folder = std::getenv("STRAKE_DATA");
    if (!folder) GTEST_SKIP() << "STRAKE_DATA is not set";  // the surfaces are not ours to ship
    const Expected& e = GetParam();
    const auto file = std::filesystem::path(folder) / e.file;
    if (!std::filesystem::exists(file)) GTEST_SKIP() << e.file << " is not there";  // a smaller collection
    const TriMesh mesh = welded(read_surface(file).mesh);
    const TopologyFacts f = topology(mesh, adjacency(mesh));
    EXPECT_EQ(mesh.num_vertices(), e.vertices);
    EXPECT_EQ(mesh.num_triangles(), e.triangles);
    EXPECT_EQ(f.components, e.components);
    EXPECT_EQ(static_cast<int>(f.boundary_loops.size()), e.loops);
    EXPECT_EQ(static_cast<int>(f.nonmanifold_edges.size()), e.nonmanifold_edges);
    EXPECT_EQ(static_cast<int>(f.misoriented_edges.size()), e.misoriented_edges);
    EXPECT_EQ(f.closed, e.closed);
    EXPECT_NEAR(corner_angles(mesh).minCoeff() * 180 / M_PI, e.min_angle_deg, 0.005 * e.min_angle_deg + 1e-4);
#ifndef __SANITIZE_ADDRESS__  // minutes
    EXPECT_EQ(static_cast<int>(self_intersections(mesh).size()), e.intersections);
#endif
}

INSTANTIATE_TEST_SUITE_P(All, ReferenceSurfaces, testing::ValuesIn(table));

}  // namespace
}  // namespace strake
