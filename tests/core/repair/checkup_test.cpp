#include "core/repair/checkup.hpp"
#include "core/error.hpp"
#include "core/repair/repair.hpp"

#include "defective.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace strake {
namespace {

using namespace defective;

TEST(Checkup, LoopsAreMeasuredAndPlanesFound) {
    const TriMesh tube = without(box_surface({1, 2, 3}, 4), [](int) { return false; });
    const TriMesh open = without(tube, [&](int t) { return centroid(tube, t).y() < 1e-12; });
    const Checkup found = checkup(open);
    ASSERT_EQ(found.loops.size(), 1u);
    const BoundaryLoop& loop = found.loops[0];
    EXPECT_NEAR(loop.length, 8, 1e-12);
    EXPECT_NEAR(loop.size, std::sqrt(10.0), 1e-12);
    EXPECT_TRUE(loop.is_planar);
    EXPECT_NEAR(loop.normal.y(), 1, 1e-12);
    EXPECT_EQ(loop.symmetry_axis, 1);
    EXPECT_EQ(loop.symmetry_at, 0);
    const TriMesh ball = icosphere(3);
    const Checkup torn = checkup(without(ball, [&](int t) { return centroid(ball, t).z() > 0.5; }));
    ASSERT_EQ(torn.loops.size(), 1u);
    EXPECT_EQ(torn.loops[0].symmetry_axis, -1);
}

TEST(Checkup, AFlatSheetHasNoSymmetryPlane) {
    EXPECT_EQ(checkup(strip(2, 1, 4, 2)).loops.at(0).symmetry_axis, -1);
    EXPECT_TRUE(checkup(strip(2, 1, 4, 2)).loops.at(0).is_planar);
}

TEST(Checkup, FoldsAreFoundAndKnifeEdgesAreNone) {
    TriMesh sheet = strip(4, 4, 4, 4, 0);
    EXPECT_TRUE(checkup(sheet).inverted_triangles.empty());
    for (int v = 0; v < sheet.num_vertices(); ++v)
        if ((sheet.vertices.row(v) - Eigen::RowVector3d(2, 2, 0)).norm() < 1e-9) sheet.vertices.row(v) << 3.2, 2.6, 0;
    const Checkup folded = checkup(sheet);
    EXPECT_FALSE(folded.inverted_triangles.empty());
    for (const int t : folded.inverted_triangles) EXPECT_LT(area_vector(sheet, t).z(), 0);
    TriMesh wedge = box_surface({4, 1, 1}, 6);  // to an edge of 1.4 degrees at x = 4
    for (int v = 0; v < wedge.num_vertices(); ++v)
        wedge.vertices(v, 2) = (wedge.vertices(v, 2) - 0.5) * 0.1 * (1.0 - wedge.vertices(v, 0) / 4.001);
    EXPECT_TRUE(checkup(wedge).inverted_triangles.empty());
}

TEST(Checkup, HistogramsHoldEverything) {
    const TriMesh mesh = capped_cylinder(12, 3);
    const Checkup found = checkup(mesh);
    const auto sum = [](const Histogram& h) { return std::accumulate(h.counts.begin(), h.counts.end(), 0); };
    EXPECT_EQ(sum(found.quality.angles_deg), 3 * mesh.num_triangles());
    EXPECT_EQ(sum(found.quality.ratios), mesh.num_triangles());
    EXPECT_EQ(sum(found.quality.edges), found.adjacent.num_edges());
    const SurfaceQuality even = checkup(icosphere(0)).quality;
    EXPECT_NEAR(even.mean, 1, 1e-12);
    EXPECT_NEAR(even.smallest, 1, 1e-12);
    EXPECT_EQ(even.angles_deg.counts[4] + even.angles_deg.counts[3], 60);
}

TEST(Checkup, EveryDefectIsMarked) {
    TriMesh mesh = turned(icosphere(2), [](int t) { return t == 9; });
    add_triangle(mesh, mesh.triangles(30, 0), mesh.triangles(30, 1), mesh.triangles(30, 2));
    add_vertex(mesh, {5, 5, 5});
    const DefectFields fields = defect_fields(mesh, checkup(mesh));
    const auto marked = [](const std::vector<Field>& list, const std::string& name) {
        for (const Field& field : list)
            if (field.name == name) return std::get<std::vector<int>>(field.values);
        return std::vector<int>{};
    };
    EXPECT_EQ(marked(fields.cells, "misoriented").at(9), 1);
    EXPECT_EQ(marked(fields.cells, "duplicate").back(), 1);
    EXPECT_EQ(marked(fields.cells, "nonmanifold_edge").at(30), 1);
    EXPECT_EQ(marked(fields.points, "isolated").back(), 1);
    EXPECT_NO_THROW(vtp_bytes(mesh, fields.points, fields.cells));
}

TEST(Checkup, AdviceNamesTheOptions) {
    const auto advised = [](const TriMesh& mesh) { return advice(mesh, checkup(mesh)); };
    EXPECT_TRUE(advised(icosphere(1)).empty());
    const auto flipped = advised(turned(icosphere(1), [](int t) { return t == 0; }));
    ASSERT_EQ(flipped.size(), 1u);
    EXPECT_EQ(flipped[0],
              "strake repair SURFACE --out FILE --orient leaves 0 of 3 edges that disagree in orientation (tried on a "
              "copy)");
    const auto moebius = advised(twisted_band(24, 1));
    ASSERT_EQ(moebius.size(), 1u);  // nothing that would close it
    EXPECT_NE(moebius.back().find("orientable: cut it across"), std::string::npos);
}

/// A repair that makes anything worse is not proposed, and the numbers are those of a trial.
TEST(Checkup, AdviceIsTriedOnACopy) {
    const auto advised = [](const TriMesh& mesh) { return advice(mesh, checkup(mesh)); };
    // A fin on a sphere, with one triangle turned: apart from the sphere it would be a loop more.
    TriMesh fin = turned(icosphere(2), [](int t) { return t == 200; });
    const int v = fin.num_vertices();
    add_vertex(fin, {3, 0, 0});
    add_triangle(fin, fin.triangles(0, 0), fin.triangles(0, 1), v);
    const Checkup before = checkup(fin);
    ASSERT_EQ(before.facts.nonmanifold_edges.size(), 1u);
    for (const std::string& words : advised(fin)) {
        if (words.find("strake repair") == std::string::npos) continue;
        RepairOptions options;
        options.orient = words.find("--orient") != std::string::npos;
        options.split = words.find("--split") != std::string::npos;
        if (words.find("--holes") != std::string::npos) continue;
        const Checkup after = repair(fin, options).after;
        EXPECT_LE(after.facts.boundary_loops.size(), before.facts.boundary_loops.size()) << words;
        EXPECT_LE(after.facts.misoriented_edges.size(), before.facts.misoriented_edges.size()) << words;
        EXPECT_NE(words.find(text(after.facts.misoriented_edges.size(), " of ", before.facts.misoriented_edges.size(),
                                  " edges that disagree in orientation")),
                  std::string::npos)
            << words;
    }
    EXPECT_TRUE(advised(fin).size() >= 1);
}

TEST(Checkup, HalfABodyIsAskedOnceAndOnlyOfHalves) {
    const auto asked = [](const TriMesh& mesh) {
        const Checkup found = checkup(mesh);
        int count = 0;
        for (const auto& list : {advice(mesh, found), defects_in_words(mesh, found)})
            for (const std::string& words : list)
                count +=
                    words.find("half a ") != std::string::npos || words.find("symmetry plane?") != std::string::npos;
        return count;
    };
    const TriMesh box = box_surface({1, 2, 3}, 4);
    EXPECT_EQ(asked(without(box, [&](int t) { return centroid(box, t).y() < 1e-12; })), 1);
    EXPECT_EQ(asked(icosphere(2)), 0);
    EXPECT_EQ(asked(strip(1, 1, 4, 4)), 0) << "a flat sheet";
    const TriMesh tube =
        without(box, [&](int t) { return centroid(box, t).y() < 1e-12 || centroid(box, t).y() > 2 - 1e-12; });
    EXPECT_EQ(asked(tube), 0);
}

}  // namespace
}  // namespace strake
