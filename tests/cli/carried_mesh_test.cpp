#include "cases/geometry/closed_body.hpp"
#include "cases/geometry/lifting_body.hpp"
#include "cases/geometry/slender_body.hpp"
#include "cases/geometry/wing.hpp"
#include "cli/run_strake.hpp"
#include "core/error.hpp"
#include "core/formats/io.hpp"
#include "core/mesh/closest_point.hpp"
#include "core/mesh/geometry.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// A body of four times the triangles goes where its own skin would take it.
namespace strake {
namespace {

struct Body {
    const char* name;
    int axis;  ///< along which it is held at one end and loaded at the other
    TriMesh (*make)(int triangles);
    int triangles;
    const char* more;  ///< of the case
};

void PrintTo(const Body& body, std::ostream* out) { *out << body.name; }

const Body bodies[] = {
    {"wing", 1, [](int n) { return example::wing(n); }, 1300, "symmetry: {plane: y, at: 0}\n"},
    {"ellipsoid", 0,
     [](int n) {
         return example::superellipsoid(n, {{0.5, 0.1, 0.1}, 2});
     },
     1300, ""},
    {"lifting_body", 0, [](int n) { return example::lifting_body(n); }, 2000, ""},
    {"fuselage", 0, [](int n) { return example::wavy_body(n); }, 2000, ""},
};

class CarriedMesh : public testing::TestWithParam<Body> {
protected:
    TempFolder folder;
    std::string path(const std::string& name) const { return (folder / name).string(); }

    /// The numbers of the triangles of `mesh` whose place on `of` is one of `marked`, as a file.
    void write_region(const std::string& name, const TriMesh& mesh, const TriMesh& of,
                      const std::vector<char>& marked) {
        const ClosestPointTree tree(of);
        const Points centroids = triangle_centroids(mesh);
        std::string lines;
        for (int t = 0; t < mesh.num_triangles(); ++t)
            if (marked[static_cast<std::size_t>(tree.find(centroids.row(t)).triangle)]) lines += text(t, "\n");
        folder.write(name, lines);
    }

    /// Bent by 5 % of the diagonal: the held fifth and the loaded fifth are those of `coarse`, whatever the triangles,
    /// for a border that is elsewhere by half a triangle is another case.
    void bend(const std::string& name, const TriMesh& mesh, const TriMesh& coarse) {
        const int axis = GetParam().axis;
        const double low = coarse.vertices.col(axis).minCoeff(), size = coarse.vertices.col(axis).maxCoeff() - low;
        std::vector<char> held(static_cast<std::size_t>(coarse.num_triangles())), loaded = held;
        const Points centroids = triangle_centroids(coarse);
        for (int t = 0; t < coarse.num_triangles(); ++t) {
            held[static_cast<std::size_t>(t)] = centroids(t, axis) < low + 0.2 * size;
            loaded[static_cast<std::size_t>(t)] = centroids(t, axis) > low + 0.8 * size;
        }
        write_surface(folder / (name + ".obj"), mesh, SurfaceFormat::obj);
        write_region(name + "_held.txt", mesh, coarse, held);
        write_region(name + "_loaded.txt", mesh, coarse, loaded);
        folder.write(name + ".yaml", text("case: t\nsurface: {file: ", name, ".obj}\n", GetParam().more,
                                          "regions: {a: {triangles: ", name, "_held.txt}, b: {triangles: ", name,
                                          "_loaded.txt}}\nfixed: [a]\n",
                                          "loads: [{region: b, displacement: 5%, direction: [0, 0.2, 1]}]\n"));
        const ProgramRun bent = run_strake({"deform", path(name + ".yaml"), "-o", path(name + "_bent.obj"), "-q"});
        ASSERT_EQ(bent.status, 0) << bent.err;
    }
};

TEST_P(CarriedMesh, IsWithinOnePercentOfTheLargestDisplacement) {
    const TriMesh coarse = GetParam().make(GetParam().triangles), fine = GetParam().make(4 * GetParam().triangles);
    ASSERT_GT(fine.num_triangles(), 3.6 * coarse.num_triangles());
    bend("coarse", coarse, coarse);
    bend("fine", fine, coarse);
    const ProgramRun applied = run_strake(
        {"apply", path("coarse.obj"), path("fine.obj"), "--moved", path("coarse_bent.obj"), "-o", path("carried.obj")});
    ASSERT_EQ(applied.status, 0) << applied.err;
    const auto told =
        nlohmann::json::parse(run_strake({"compare", path("carried.obj"), path("fine_bent.obj"), "--json"}).out);
    const Points wanted = read_surface(path("fine_bent.obj")).mesh.vertices;
    const double moved = (wanted - fine.vertices).rowwise().norm().maxCoeff();
    EXPECT_GT(moved, 0.045 * box_diagonal(fine));
    EXPECT_LT(told["distance"]["max"], 0.01 * moved);
    RecordProperty("distance", text(told["distance"]["max"].get<double>() / moved));
}

INSTANTIATE_TEST_SUITE_P(Bodies, CarriedMesh, testing::ValuesIn(bodies),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace strake
